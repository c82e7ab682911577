"""Fluids in place: closed forms for linear and kinked maps, sums, fluids, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import InputError
from tests.grids import gridded

NUMBERS = {"net_to_gross": 0.8, "porosity": 0.25, "water_saturation": 0.3}
ALL = {**NUMBERS, "formation_volume_factor": {"oil": 1.25, "gas": 0.005}}
VOLUMES = ("bulk", "net", "pore", "hydrocarbon_pore", "stoiip", "giip")


def given(values: Any, x: np.ndarray, y: np.ndarray) -> xr.DataArray:
    """A map over easting and northing; values may be a function of both."""
    found = values(x[None, :], y[:, None]) if callable(values) else values
    return gridded(found, x, y).drop_attrs()


def rotated(values: Any, angle: float, n: int = 20) -> xr.DataArray:
    """A map over a rotated grid that covers 4000 x 3000 m."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    u, v = np.meshgrid(np.linspace(-3000.0, 3000.0, n), np.linspace(-3100.0, 2900.0, n + 3))
    x, y = 2000.0 + c * u - s * v, 1500.0 + s * u + c * v
    return gridded(values(x, y), x, y).drop_attrs()


@pytest.fixture(scope="module")
def tilted(planes: gs.Scene) -> gs.Scene:
    """Two blocks of planes above and below two contacts."""
    return planes.replace(contacts={"GOC": -2060.0, "OWC": -2120.0})


def over_tetrahedra(unit: gs.Unit, *parts: Any) -> list[float]:
    """Integrals of a function, of its product with the next one ..., by points in tetrahedra."""
    t = unit.vertices[unit.triangles]
    apex = unit.vertices.mean(axis=0)
    edges = [t[:, k] - apex for k in range(3)]
    size = np.einsum("ij,ij->i", np.cross(edges[0], edges[1]), edges[2])
    g, w = np.polynomial.legendre.leggauss(4)  # exact to degree 7
    g, w = 0.5 + 0.5 * g, 0.5 * w
    found = np.zeros(len(parts))
    for i, j, k in np.ndindex(4, 4, 4):
        a, b = g[i], g[j] * (1 - g[i])
        at = apex + a * edges[0] + b * edges[1] + g[k] * (1 - a - b) * edges[2]
        values = np.cumprod([part(at[:, 0], at[:, 1]) for part in parts], axis=0)
        found += values @ size * (w[i] * w[j] * w[k] * (1 - a) * (1 - a - b))
    return found.tolist()


def test_linear_and_bilinear_maps_have_closed_forms_on_any_grids(tilted: gs.Scene) -> None:
    def ntg(x: Any, y: Any) -> Any:
        return 0.5 + x / 2e4 + y / 3e4

    def porosity(x: Any, y: Any) -> Any:
        return 0.3 - x / 4e4 + y / 6e4

    def water(x: Any, y: Any) -> Any:
        return 0.2 + x * y / 5e7

    x, y = np.linspace(-100.0, 4100.0, 17), np.linspace(0.0, 3000.0, 12)
    found = tilted.volumetrics(
        net_to_gross=rotated(ntg, 30.0),
        porosity=given(porosity, x[::-1], y),
        water_saturation=given(water, np.linspace(0.0, 4000.0, 7), y[::-1]),
        formation_volume_factor={"oil": 1.25, "gas": given(lambda x, y: 0.005 + 0 * x * y, x, y)},
    )
    for name, unit in tilted.units.included().items():
        row = found.sel(unit=name)
        exact = over_tetrahedra(unit, ntg, porosity, lambda x, y: 1.0 - water(x, y))
        fluid = row.fluid.item()
        exact[2] *= fluid != "water"
        values = [row[key].item() for key in VOLUMES[1:4]]
        assert values == pytest.approx(exact, rel=1e-12)
        assert row.stoiip.item() == pytest.approx(exact[2] / 1.25 * (fluid == "oil"), rel=1e-12)
        assert row.giip.item() == pytest.approx(exact[2] / 0.005 * (fluid == "gas"), rel=1e-12)


def test_kinks_of_a_map_are_met_exactly() -> None:
    """Over flat rock the integral is thickness times means of corners, cell by cell."""
    flat = given(np.zeros((3, 3)), np.array([0.0, 500.0, 1000.0]), np.array([0.0, 450.0, 800.0]))
    flat.attrs = {"units": "m", "positive": "up"}
    box = (0, 1000, 0, 800, -2100, -1900)
    horizons = {"Top": flat - 2000.0, "Base": flat - 2040.0}
    scene = gs.Scene(horizons, box=box, positive="up", length_unit="m")
    rng = np.random.default_rng(4)
    x, y = (np.sort([0.0, end, *rng.uniform(0, end, 9)]) for end in (1000.0, 800.0))
    z = rng.uniform(size=(11, 11))
    means = 0.25 * (z[1:, 1:] + z[1:, :-1] + z[:-1, 1:] + z[:-1, :-1])
    exact = 40.0 * (np.diff(y)[:, None] * np.diff(x) * means).sum()
    assert scene.volumetrics(net_to_gross=given(z, x, y)).net.item() == pytest.approx(
        exact, rel=1e-12
    )


def test_a_map_and_its_finer_form_are_the_same_and_maps_add_up(graben: gs.Scene) -> None:
    w, e, s, n = graben.box[:4]
    rng = np.random.default_rng(5)
    x, y = np.linspace(w, e, 6), np.linspace(s, n, 9)
    one, other = (given(rng.uniform(0.0, 0.5, (9, 6)), x, y) for _ in range(2))
    more = np.sort([*x, *rng.uniform(w, e, 7)]), np.sort([*y, *rng.uniform(s, n, 5)])
    fine = one.interp(easting=more[0], northing=more[1])
    net = [graben.volumetrics(net_to_gross=each).net for each in (one, fine, other, one + other)]
    np.testing.assert_allclose(net[1], net[0], rtol=1e-12)
    np.testing.assert_allclose(net[0] + net[2], net[3], rtol=1e-12)


def test_constants_are_maps_of_one_value_and_sums_are_those_of_the_reservoir(
    tilted: gs.Scene,
) -> None:
    number = tilted.volumetrics(**ALL)
    maps = {key: rotated(lambda x, y, of=of: of + 0 * x, 10.0, 9) for key, of in NUMBERS.items()}
    same = tilted.volumetrics(**{**ALL, **maps})
    for key in VOLUMES:
        np.testing.assert_allclose(same[key], number[key], rtol=1e-11)

    # contacts split rock, and change neither rock nor pores
    poro = rotated(lambda x, y: 0.2 + x / 1e5, -20.0)
    whole = tilted.replace(contacts={}).volumetrics(net_to_gross=0.8, porosity=poro)
    parts = tilted.volumetrics(net_to_gross=0.8, porosity=poro)
    assert float(parts.pore.sum()) == pytest.approx(float(whole.pore.sum()), rel=1e-12)
    by_fluid = number.groupby("fluid").sum()
    assert float(by_fluid.bulk.sum()) == pytest.approx(float(tilted.volumes.sum()), rel=1e-12)
    assert by_fluid.hydrocarbon_pore.sel(fluid="water") == 0.0
    oil = by_fluid.sel(fluid="oil")
    assert float(oil.stoiip / oil.bulk) == pytest.approx(0.8 * 0.25 * 0.7 / 1.25, rel=1e-12)
    assert float(oil.giip) == 0.0 < float(by_fluid.giip.sel(fluid="gas"))


def test_the_most_specific_entry_counts_and_field_units_are_the_same_volumes(
    tilted: gs.Scene,
) -> None:
    porosity = {"elsewhere": 0.1, "Top/Base": 0.2, ("Top/Base", "oil"): 0.25}
    porosity["A", "oil", "Top/Base"] = 0.15
    found = tilted.volumetrics(**{**ALL, "porosity": porosity})
    in_oil = np.where(found.region == "A", 0.15, 0.25)
    expected = np.where(found.fluid == "oil", in_oil, 0.2)
    assert set(expected.tolist()) == {0.15, 0.2, 0.25}
    np.testing.assert_allclose(found.pore / found.net, expected, rtol=1e-12)
    field = tilted.volumetrics(**{**ALL, "porosity": porosity}, units="field")
    sizes = {"bulk": 1233.4818, "pore": 0.15898729, "stoiip": 0.15898729, "giip": 0.028316847}
    for key, size in sizes.items():
        np.testing.assert_allclose(field[key] * size, found[key], rtol=1e-7)
    assert [field[key].attrs["units"] for key in sizes] == ["acre-ft", "bbl", "stb", "scf"]


def test_fluids_follow_the_names_of_contacts_unless_users_say_otherwise(tilted: gs.Scene) -> None:
    found = tilted.volumetrics(**ALL)
    pairs = set(zip(found.contact.values.tolist(), found.fluid.values.tolist(), strict=True))
    assert pairs == {("above GOC", "gas"), ("GOC/OWC", "oil"), ("below OWC", "water")}
    unnamed = tilted.replace(contacts={"Level": -2120.0})
    with pytest.raises(InputError, match=r"fluid of unit .*above Level.* is not known.*fluids="):
        unnamed.volumetrics(**ALL)
    said = unnamed.volumetrics(**ALL, fluids={"above Level": "gas", "elsewhere": "water"})
    assert set(said.fluid.values) == {"gas", "water"}
    same = {"above GOC": "oil", "elsewhere": "oil"}
    assert (tilted.volumetrics(**NUMBERS, fluids=same).fluid == "gas").sum() == 0


def test_outside_the_reservoir_nothing_has_to_be_given(tilted: gs.Scene) -> None:
    given = {**ALL, "porosity": {"Top/Base": 0.25, "below Base": 0.1}, "fluids": "oil"}
    every = tilted.volumetrics(**given, include="all")
    inside = tilted.volumetrics(**given)
    xr.testing.assert_equal(every.sel(unit=inside.unit).drop_vars("reservoir"), inside)
    outside = every.sel(unit=~every.reservoir)
    assert set(outside.fluid.values) == {""}
    assert (outside.bulk > 0.0).all()
    assert outside.stoiip.isnull().all()
    has_porosity = (outside.zone == "below Base").values
    assert (outside.pore.notnull().values == has_porosity).all()
    named = tilted.volumetrics(**{**given, "fluids": {"below Base": "water"}}, include="all")
    assert set(named.fluid.values[named.zone == "below Base"]) == {"water"}
    assert (named.stoiip[named.zone == "below Base"] == 0.0).all()


X, Y = np.array([0.0, 4000.0]), np.array([0.0, 1000.0, 3000.0])
HALF = given(np.array([[0.2, 0.2], [0.2, 0.2], [0.2, np.nan]]), X, Y)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"net_to_gross": None}, "volumetrics needs net_to_gross, which is missing"),
        ({"porosity": 25}, "porosity is 25; it must be from 0 to 1 .divide percent by 100"),
        ({"porosity": given(np.full((3, 2), -0.1), X, Y)}, "porosity is -0.1"),
        ({"porosity": HALF.assign_attrs(units="%")}, "the map of porosity is in '%'"),
        ({"porosity": HALF}, r"map of porosity has no values over .* km² .*such as at \(E "),
        ({"porosity": {"Top/Bas": 0.2}}, "'Top/Bas', but no unit.*Did you mean 'Top/Base'"),
        ({"porosity": {"oil": 0.2}}, "porosity has no value for unit .* GOC"),
        ({"porosity": {"oil": 0.2, "F1+": 0.3, "elsewhere": 0.1}}, "entries for 'F1[+]' and for"),
        ({"formation_volume_factor": 1.3}, "is 1.3 for gas in unit .*below 1"),
    ],
)
def test_what_is_wrong_is_named(tilted: gs.Scene, change: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        tilted.volumetrics(**{**ALL, **change})
