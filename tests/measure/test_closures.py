"""Closures: ridges with closed forms, faults that hold, leak or are passed, grids and mirrors."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from scipy.ndimage import label

import geosurf as gs
from geosurf.errors import InputError
from geosurf.synthetic.world import make_fault
from tests.grids import gridded, lines_of, ring_area
from tests.messages import refused

X = np.arange(0.0, 2001.0, 100.0)
Y = np.arange(-600.0, 601.0, 200.0)
AT = 950.0  # of the fault, between two nodes
BOX = (0.0, 2000.0, -600.0, 600.0, -2600.0, -1400.0)


def grid(values: np.ndarray, x: np.ndarray = X, y: np.ndarray = Y) -> xr.DataArray:
    """A gridded horizon."""
    return gridded(values, x, y)


def upright(at: float = AT) -> xr.Dataset:
    """A vertical fault from south to north."""
    z, y = np.meshgrid([-1300.0, -2700.0], [-900.0, 900.0], indexing="ij")
    return make_fault("F1", np.full_like(z, at), y, z, (0.0, 0.0, 0.0))


def thrown(levels: dict[str, np.ndarray], throw: float, fault: xr.Dataset) -> dict[str, gs.Sheet]:
    """Horizons of some elevations that one fault throws."""
    return {
        name: gs.throw_horizon(grid(z), {"F1": fault}, {"F1": throw}, name=name)
        for name, z in levels.items()
    }


class Ridge:
    """A crest line of any heights along y = 0, with flanks of one dip; a fault may throw it."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.crest = -1900.0 + rng.uniform(-60.0, 60.0, len(X))
        self.dip, self.thick = rng.uniform(0.05, 0.3), rng.uniform(20.0, 120.0)
        self.throw = float(rng.choice([0.0, rng.uniform(5.0, 60.0), rng.uniform(60.0, 150.0)]))

    def scene(self) -> gs.Scene:
        """The model."""
        top = self.crest - self.dip * abs(Y[:, None])
        levels, fault = {"Top": top, "Base": top - self.thick}, upright()
        horizons = {name: grid(z) for name, z in levels.items()}
        if self.throw:
            horizons = thrown(levels, self.throw, fault)
        return gs.Scene(horizons, {"F1": fault}, BOX)

    def closures(self, rule: str) -> list[tuple[float, ...]]:
        """Crest, level, area and volume of all closures: level by level, on the crest line."""
        at_fault = float(np.interp(AT, X, self.crest))
        west, east = X < AT, X > AT
        x = np.concatenate([X[west], [AT, AT], X[east]])
        z = np.concatenate(
            [self.crest[west], [at_fault], [at_fault, *self.crest[east]] - np.float64(self.throw)]
        )
        k = int(west.sum())
        links = [(i, i + 1, min(z[i : i + 2])) for i in range(len(x) - 1) if i != k]
        if rule == "juxtaposition" and self.throw < self.thick:
            links.append((k, k + 1, z[k + 1]))
        exits = [(0, z[0]), (len(x) - 1, z[-1])]
        exits += [(i, z[i] - self.dip * Y[-1]) for i in range(len(x))]
        exits += [(k, z[k]), (k + 1, z[k + 1])] if rule == "open" else []

        def parts(level: float, *, with_it: bool) -> list[frozenset[int]]:
            on = z >= level if with_it else z > level
            group = np.arange(len(x))
            for i, j, height in sorted(links, key=lambda link: -link[2]):
                if height > level or (with_it and height == level):
                    group[group == group[j]] = group[i]
            return [frozenset(np.flatnonzero(on & (group == g)).tolist()) for g in set(group[on])]

        found = []
        for level in sorted({link[2] for link in links} | {height for _, height in exits}):
            joined = parts(level, with_it=True)
            closed = [
                p
                for p in parts(level, with_it=False)
                if not any(i in p and height > level for i, height in exits)
            ]
            for part in closed:
                whole = next(of for of in joined if part <= of)
                meets = sum(other <= whole for other in parts(level, with_it=False)) > 1
                if meets or any(i in whole and height == level for i, height in exits):
                    area = volume = 0.0
                    for i, j in pairwise(range(len(x))):
                        if (i, j) != (k, k + 1) and (i in part or j in part):
                            ends = np.array([z[i], z[j]]) - level
                            area += 2.0 / self.dip * power(ends, x[j] - x[i], 1)
                            volume += power(ends, x[j] - x[i], 2) / self.dip
                            volume -= power(ends - self.thick, x[j] - x[i], 2) / self.dip
                    found.append((max(z[i] for i in part), level, area, volume))
        return found


def power(ends: np.ndarray, length: float, n: int) -> float:
    """Integral of the positive part of a line, to a power, between its ends."""
    low, high = sorted(ends)
    if high <= 0.0:
        return 0.0
    low_part = max(low, 0.0)
    if high == low:
        return float(high**n * length)
    return float(length / (high - low) * (high ** (n + 1) - low_part ** (n + 1)) / (n + 1))


def off(seed: int, rule: str) -> tuple[int, float]:
    """Number of closures of a ridge, and how far they are from the closed forms."""
    ridge = Ridge(seed)
    found = ridge.scene().closures("Top", faults=rule, min_height=0.0)
    columns = [found[key].values for key in ("crest_elevation", "level", "area", "volume")]
    mine = np.array(sorted(zip(*columns, strict=True))).reshape(-1, 4)
    known = np.array(sorted(ridge.closures(rule))).reshape(-1, 4)
    assert mine.shape == known.shape
    return len(known), float(np.abs(mine / known - 1.0).max(initial=0.0))


RULES = ("sealing", "open", "juxtaposition")


def parts_of(closures: xr.Dataset) -> list[tuple[float, ...]]:
    """What two models of one closure share, sorted."""
    keys = ("level", "crest_elevation", "crest_northing", "spill_northing", "area", "volume")
    return sorted(zip(*(closures[key].values.tolist() for key in keys), strict=True))


def hills(seed: int, n: int = 21, size: float = 4000.0) -> xr.DataArray:
    """A smooth random horizon."""
    rng, axis = np.random.default_rng(seed), np.linspace(0.0, size, n)
    x, y = np.meshgrid(axis, axis)
    z = -2000.0 + 0.02 * rng.normal() * x + 0.02 * rng.normal() * y
    for height, east, north, wide in rng.uniform(
        (-120.0, 0.0, 0.0, 250.0), (160.0, size, size, 900.0), (8, 4)
    ):
        z = z + height * np.exp(-((x - east) ** 2 + (y - north) ** 2) / (2.0 * wide**2))
    return grid(z, axis, axis)


@pytest.mark.parametrize("rule", RULES)
def test_ridges_have_the_closures_of_their_crest_lines(rule: str) -> None:
    # culminations that spill into each other, saddles and blocks at faults, leaks by juxtaposition
    counts, errors = zip(*(off(seed, rule) for seed in range(3)), strict=True)
    assert min(counts) > 0
    assert max(errors) < 1e-10


def test_two_culminations_spill_into_each_other() -> None:
    z = np.interp(X, [0, 500, 900, 1400, 2000], [-2000.0, -1800.0, -1860.0, -1830.0, -2000.0])
    top = grid(z - 0.4 * abs(Y[:, None]))
    found = gs.Scene({"Top": top, "Base": top.copy(data=top - 30.0)}, box=BOX).closures("Top")
    assert found.closure.values.tolist() == ["Top 1", "Top 2", "Top 1+2"]
    assert found.spills_into.values.tolist() == ["Top 2", "Top 1", ""]
    assert found.part_of.values.tolist() == ["Top 1+2", "Top 1+2", ""]
    assert found.spill_kind.values.tolist() == ["saddle", "saddle", "edge"]
    assert found.spill_easting.values[:2].tolist() == [900.0, 900.0]

    # the way up ends on the other crest; outlines hold the areas
    lines = lines_of(found, "easting", "northing", "elevation")
    kinds = list(zip(found.line_kind.values, found.line_closure.values, strict=True))
    path = lines[kinds.index(("path", "Top 1"))]
    assert (np.diff(path[:, 2]) > 0.0).all()
    assert path[[0, -1], 0].tolist() == [900.0, 1400.0]
    for name in found.closure.values:
        ring = lines[kinds.index(("outline", name))]
        assert ring_area(ring[:, :2]) == pytest.approx(
            float(found.area.sel(closure=name)), rel=1e-12
        )


def test_a_contact_at_the_spill_point_holds_the_same_volume() -> None:
    # of a footwall: some of its rock lies below the fault, and not below its horizon
    axis = np.linspace(0.0, 4000.0, 21)
    top = 0.08 * (axis - 2000.0) - 0.05 * abs(axis - 2000.0)[:, None] - 2000.0
    z, y = np.meshgrid(np.linspace(-1400.0, -2600.0, 3), [-200.0, 4200.0], indexing="ij")
    faults = {"F1": make_fault("F1", 2010.0 - 0.6 * (2000.0 + z), y, z, (0.0, 0.0, 0.0))}
    horizons = {
        name: gs.throw_horizon(grid(top - below, axis, axis), faults, {"F1": 80.0}, name=name)
        for name, below in (("Top", 0.0), ("Base", 120.0))
    }
    scene = gs.Scene(horizons, faults, (0.0, 4000.0, 0.0, 4000.0, -2600.0, -1400.0))
    for rule, kind in (("sealing", "edge"), ("juxtaposition", "fault")):
        found = scene.closures("Top", faults=rule)
        assert found.spill_kind.values.tolist() == [kind]
        contact = gs.FluidContact(float(found.level[0]), zones="Top/Base", block="F1-")
        units = scene.replace(contacts={"OWC": contact}).units
        known = units["Top/Base F1- above OWC"].volume
        assert float(found.volume[0]) == pytest.approx(known, rel=1e-9)
        assert float(found.area[0]) < units["Top/Base F1- above OWC"].map_area
    assert float(found.height[0]) == pytest.approx(80.0, abs=1e-9)  # the throw: Top faces Top


def test_faults_without_throw_are_passed_and_mirrors_change_nothing() -> None:
    top = hills(3)
    base, box = top.copy(data=top - 70.0), (0.0, 4000.0, 0.0, 4000.0, -2700.0, -1300.0)
    z, y = np.meshgrid([-1200.0, -2800.0], [-100.0, 4100.0], indexing="ij")
    wall = gs.TriSurface("F1", "fault", *plane(1700.0 - 0.6 * (z + 2000.0) + 0.1 * y, y, z))
    surfaces = {k: gs.triangulate_horizon(v, name=k) for k, v in (("Top", top), ("Base", base))}

    def moved(sign: int, east: float, faults: bool = True) -> gs.Scene:
        def of(surface: gs.TriSurface) -> gs.TriSurface:
            x = surface.vertices * [sign, 1, 1] + [east, 0, 0]
            return gs.TriSurface(surface.name, surface.role, x, surface.triangles[:, ::sign])

        west, far = sorted((east, 4000.0 * sign + east))
        horizons = {name: of(surface) for name, surface in surfaces.items()}
        return gs.Scene(horizons, {"F1": of(wall)} if faults else {}, (west, far, *box[2:]))

    plain = parts_of(moved(1, 0.0, faults=False).closures("Top"))
    passed = parts_of(moved(1, 0.0).closures("Top", faults="juxtaposition"))
    np.testing.assert_allclose(passed, plain, rtol=1e-9)
    for rule in RULES:
        known = parts_of(moved(1, 0.0).closures("Top", faults={"F1": rule}))
        assert known
        for sign, east in ((-1, 0.0), (1, 2.0**20)):
            mine = parts_of(moved(sign, east).closures("Top", faults=rule))
            np.testing.assert_allclose(mine, known, rtol=1e-9)


def plane(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a 2 x 2 grid."""
    return np.stack([x, y, z], axis=-1).reshape(4, 3), np.array([[0, 2, 3], [0, 3, 1]])


@pytest.mark.parametrize("seed", [0, 4])
def test_flooding_of_cells_comes_nearer_with_their_size(seed: int) -> None:
    top = hills(seed)
    base = top.copy(data=top - 40.0)
    found = gs.Scene({"Top": top, "Base": base}).closures("Top", min_height=3.0)
    assert found.sizes["closure"] > 1
    errors = []
    for m in (6, 24):
        # middles of cells of the triangles: diagonals run from south-west to north-east
        at, share = np.divmod(np.arange(20 * m) + 0.5, m)
        i, j = np.meshgrid(at.astype(int), at.astype(int), indexing="ij")
        v, u = np.meshgrid(share / m, share / m, indexing="ij")
        a, b, c, d = (top.values[i + p, j + q] for p, q in ((0, 0), (0, 1), (1, 0), (1, 1)))
        z = np.where(u >= v, a + u * (b - a) + v * (d - b), a + v * (c - a) + u * (d - c))
        cell, off_by = 4000.0 / len(z), []
        for k in range(found.sizes["closure"]):
            # a little above the spill point, where cells cannot leak between diagonal neighbours
            one = found.isel(closure=k)
            parts, _ = label(z > float(one.level) + 0.15 * cell)
            crest = [int(float(one[f"crest_{axis}"]) / cell) for axis in ("northing", "easting")]
            near = tuple(slice(max(p - 1, 0), p + 1) for p in crest)
            mine = parts == parts[near].max()
            rock = np.minimum(z[mine] - float(one.level), 40.0).sum() * cell**2
            off_by.append(abs(rock / float(one.volume) - 1.0))
        errors.append(np.mean(off_by))
    assert errors[1] < 0.35 * errors[0]


def test_reservoirs_leak_into_each_other_past_a_shale_and_end_on_other_horizons() -> None:
    # a roof with its crest west of the fault, the east up by 60 m: A/B faces C/D from 25 m down
    top = -1800.0 - 0.1 * abs(X - 700.0) - 0.3 * abs(Y[:, None])
    levels = {"A": top, "B": top - 20.0, "C": top - 50.0, "D": top - 90.0}
    horizons = thrown(levels, -60.0, upright())
    scene = gs.Scene(horizons, {"F1": upright()}, BOX, reservoir=["A/B", "C/D"])
    found = scene.closures(faults="juxtaposition")
    assert found.horizon.values.tolist() == ["A", "A", "C", "C"]
    leaks = zip(found.leak_closure.values, found.leak_zone.values, strict=True)
    assert list(leaks) == [("A 2", "C/D"), ("C 1", "A/B")]
    np.testing.assert_allclose(found.leak_elevation, -1825.0, atol=1e-9)
    np.testing.assert_allclose(found.level[1:3], -1825.0, atol=1e-9)

    # a level unconformity cuts off the west: the horizon ends on it where it is highest there
    cut = grid(np.broadcast_to(np.where(X < 500.0, -1845.0, -1700.0), top.shape))
    eroded = gs.Scene(
        {"U": cut, "Top": grid(top), "Base": grid(top - 90.0)}, {}, BOX, column={"U": "erosional"}
    )
    one = eroded.closures("Top").isel(closure=0)
    assert (one.spill_kind.item(), one.spill_at.item()) == ("horizon", "U")


def test_contacts_below_spill_points_are_warned_of_and_bad_words_refused() -> None:
    top = grid(-1800.0 - 0.1 * abs(X - 1000.0) - 0.2 * abs(Y[:, None]))
    scene = gs.Scene({"Top": top, "Base": top.copy(data=top - 60.0)}, {"F1": upright()}, BOX)
    deep = scene.replace(contacts={"OWC": -1930.0})
    with pytest.warns(gs.GeosurfWarning, match=r"'OWC' lies 30 m below the spill point"):
        deep.closures()
    assert [one.kind for one in deep.warnings] == ["spill", "spill"]  # one on each side
    level = scene.replace(contacts={"OWC": -1890.0})
    assert level.closures().sizes["closure"] == 2
    assert level.warnings == ()
    for words, message in (
        ({"faults": "tight"}, "none of sealing, open, juxtaposition"),
        ({"faults": {"F2": "open"}}, "'F2' is none of F1, elsewhere"),
        ({"horizon": "Base"}, "no zone of the reservoir directly below"),
        ({"min_height": "5"}, "give metres"),
    ):
        refused(gs.errors.InputError, message, scene.closures, **words)


def test_a_truncation_trap_closes_where_the_unconformity_holds():
    """A nose that is eroded along its crest: nothing else closes it."""
    axis = np.linspace(0.0, 4000.0, 81)
    x, y = np.meshgrid(axis, axis)

    def top(x, y):
        return -2100.0 + 0.1 * x - 1e-4 * (y - 2000.0) ** 2

    def eroded(y):
        return -1900.0 - 5e-5 * (y - 2000.0) ** 2

    horizons = {
        name: gridded(z, axis)
        for name, z in (("U", eroded(y) + 0.0 * x), ("Top", top(x, y)), ("Base", top(x, y) - 60.0))
    }  # fmt: skip
    box = (0, 4000, 0, 4000, -2600, -1700)
    scene = gs.Scene(horizons, box=box, column={"U": "erosional"}, reservoir=["Top/Base"])
    assert scene.closures("Top").sizes["closure"] == 0
    found = scene.closures("Top", horizons={"U": "sealing"})
    assert found.spill_kind.item() == "edge"
    assert found.attrs["horizons"] == "U sealing"

    # columns of 4 m, between the lower of both and the higher of base and spill level
    fine = 2.0 + 4.0 * np.arange(1000)
    x, y = np.meshgrid(fine, fine)
    lid, level = np.minimum(top(x, y), eroded(y)), found.level.item()
    height = lid - np.maximum(top(x, y) - 60.0, level)
    assert found.volume.item() == pytest.approx(16.0 * height.clip(0.0).sum(), rel=1e-3)
    assert found.area.item() == pytest.approx(16.0 * (height > 0.0).sum(), rel=1e-3)
    for wrong in ("open ", {"Bottom": "sealing"}, {"U": "juxtaposition"}):
        refused(InputError, "horizons: ", scene.closures, "Top", horizons=wrong)
