"""Objects of other packages give the model that arrays give: real ones, and look-alikes."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeosurfError, HorizonError, InputError, SurfaceError
from tests.messages import refused

WORLD = gs.synthetic.tilted_planes(n=9)
TOP = WORLD.horizons["Top"]
SCENE = gs.Scene(WORLD.horizons, WORLD.faults, WORLD.box)


def mesh(name="F1"):
    fault = SCENE.surface(name)
    return np.array(fault.vertices), np.array(fault.triangles)


def volumes(horizons=None, faults=None, **more):
    horizons = {**WORLD.horizons, **(horizons or {})}
    return gs.Scene(horizons, {**WORLD.faults, **(faults or {})}, WORLD.box, **more).volumes


@cache
def expected():
    return volumes()


def assert_same(found):
    assert list(found.unit.values) == list(expected().unit.values)
    assert np.allclose(found.values, expected().values, rtol=1e-12)


def axes(north, east, **attrs):
    """The top of the world over axes of other names, with attributes of both coordinates."""
    made = TOP.rename(northing=north, easting=east)
    for key in (north, east):
        made[key].attrs = {"units": "m"} | {k: v[key == east] for k, v in attrs.items()}
    return made


def beside(da):
    """The top over counted dims; coordinates of places lie along them."""
    return da.drop_vars(da.dims).assign_coords(
        northing=("y", da.y.values), easting=("x", da.x.values)
    )


GRIDS = {
    "x y": lambda: axes("y", "x"),
    "capitals": lambda: axes("Y", "X").transpose(),
    "order": lambda: TOP.transpose(),
    "standard_name": lambda: axes(
        "a", "b", standard_name=("projection_y_coordinate", "projection_x_coordinate")
    ),
    "long_name": lambda: axes("a", "b", long_name=("Northing", "Easting")),
    "axis": lambda: axes("a", "b", axis="YX").transpose(),
    "name goes first": lambda: axes("y", "x", long_name=("Easting", "Northing")),
    "beside": lambda: beside(axes("y", "x")),
    "beside counts": lambda: beside(axes("y", "x")).assign_coords(y=range(9), x=range(9)),
}


@pytest.mark.parametrize("case", GRIDS)
def test_axes_are_what_their_coordinates_say(tmp_path, case):
    given = GRIDS[case]()
    assert_same_surface(*(gs.triangulate_horizon(one, name="Top") for one in (given, TOP)))
    assert_same(volumes({"Top": given}))
    one, two = (tmp_path / name for name in ("one.irapasc", "two.irapasc"))
    assert gs.write(given, one).notes == gs.write(TOP, two).notes
    assert one.read_bytes() == two.read_bytes()


def test_axes_that_say_nothing_or_degrees_are_refused():
    for given in (axes("a", "b"), axes("a", "x"), axes("x", "easting")):
        with pytest.raises(GeosurfError, match=r"expected \('northing', 'easting'"):
            gs.triangulate_horizon(given, name="Top")
    degrees = axes("y", "x")
    degrees.x.attrs["units"] = "degrees_east"
    with pytest.raises(GeosurfError, match="unknown length unit 'degrees_east'"):
        gs.triangulate_horizon(degrees, name="Top")


STICKS = [np.array([[900.0 + 9 * k, 300.0 * k, z] for z in (0, -900, -2400)]) for k in range(5)]


@pytest.mark.parametrize(
    "form",
    [list, tuple, np.array, lambda sticks: [stick.tolist() for stick in sticks]],
    ids=["list", "tuple", "array", "lists"],
)
def test_a_list_of_arrays_is_sticks(form):
    right = gs.triangulate_fault(gs.FaultSticks("F1", tuple(STICKS)))
    assert_same_surface(gs.triangulate_fault(form(STICKS), name="F1"), right)
    deep = form([stick * [1, 1, -1] for stick in STICKS])
    assert_same_surface(gs.triangulate_fault(deep, name="F1", positive="down"), right)
    scene = gs.Scene({"Top": TOP}, {"F1": deep}, WORLD.box, positive="down")
    assert_same_surface(scene.surface("F1"), right)
    again = scene.replace(faults={"F1": form(STICKS)}, positive="up")
    assert_same_surface(again.surface("F1"), right)


def assert_same_surface(one, two):
    assert np.array_equal(one.vertices, two.vertices)
    assert np.array_equal(one.triangles, two.triangles)


class Like:
    """An object with some attributes."""

    def __init__(self, **attributes):
        self.__dict__.update(attributes)


def as_pyvista(vertices, triangles):
    pv = pytest.importorskip("pyvista")
    return pv.PolyData.from_regular_faces(vertices, triangles)


def as_meshio(vertices, triangles):
    return pytest.importorskip("meshio").Mesh(vertices, [("triangle", triangles)])


def as_trimesh(vertices, triangles):
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    return trimesh.Trimesh(vertices, triangles, process=False)


MESHES = {
    "tuple": lambda v, t: (v, t),
    "list": lambda v, t: [v, t],
    "pyvista": as_pyvista,
    "meshio": as_meshio,
    "trimesh": as_trimesh,
    "vertices and faces": lambda v, t: Like(vertices=v, faces=t),
    "vertices and triangles": lambda v, t: Like(vertices=v, triangles=t),
    "vertices and edges": lambda v, t: Like(vertices=v, edges=t),
}


@pytest.mark.parametrize("make", MESHES.values(), ids=MESHES)
def test_a_mesh_is_a_fault_and_a_horizon(make):
    assert_same(volumes(faults={"F1": make(*mesh())}))
    assert_same(volumes(horizons={"Top": make(*mesh("Top"))}))
    assert gs.triangulate_fault(make(*mesh()), name="F1").n_triangle == len(mesh()[1])


def test_layers_of_pyvista_are_horizons_and_faults():
    pv = pytest.importorskip("pyvista")
    x, y = np.meshgrid(TOP.easting.values, TOP.northing.values, indexing="ij")
    z = TOP.transpose("easting", "northing").values
    z = z if TOP.attrs["positive"] == "up" else -z
    assert_same(
        volumes(horizons={"Top": pv.StructuredGrid(x[..., None], y[..., None], z[..., None])})
    )
    volume = pv.StructuredGrid(*np.meshgrid(*[np.arange(3.0)] * 3, indexing="ij"))
    refused(InputError, "is a volume", volumes, horizons={"Top": volume})
    found = gs.triangulate_fault(
        pv.StructuredGrid(*(np.stack([np.full((2, 3), 5.0), *np.mgrid[:2, :3]])[..., None])),
        name="F",
    )
    assert found.n_triangle == 4


def xtgeo_surface(rotation=0.0):
    xtgeo = pytest.importorskip("xtgeo", reason="xtgeo is not installed")
    depth = TOP if TOP.attrs["positive"] == "down" else -TOP
    return xtgeo.RegularSurface(
        ncol=TOP.sizes["easting"], nrow=TOP.sizes["northing"],
        xinc=float(TOP.easting[1] - TOP.easting[0]), yinc=float(TOP.northing[1] - TOP.northing[0]),
        xori=float(TOP.easting[0]), yori=float(TOP.northing[0]), rotation=rotation,
        values=depth.transpose("easting", "northing").values,
    )  # fmt: skip


def test_grids_of_xtgeo_are_horizons():
    assert_same(volumes(horizons={"Top": xtgeo_surface()}, positive="down"))
    refused(GeosurfError, "positive", lambda: volumes(horizons={"Top": xtgeo_surface()}))
    turned = gs.triangulate_horizon(xtgeo_surface(30.0), positive="down")
    x, y = xtgeo_surface(30.0).get_xy_values(asmasked=False)
    expected = np.stack([x.ravel(), y.ravel()], axis=1)
    found = turned.vertices[:, :2]
    order, of = np.lexsort(found.round(3).T), np.lexsort(expected.round(3).T)
    assert np.abs(found[order] - expected[of]).max() < 1e-9


def test_lines_of_xtgeo_are_sticks():
    xtgeo = pytest.importorskip("xtgeo", reason="xtgeo is not installed")
    corners = [(2000 + k, 1500 * i, 1000 + 900 * k) for i in range(3) for k in range(3)]
    rows = [(*corner, n // 3) for n, corner in enumerate(corners)]
    found = gs.triangulate_fault(xtgeo.Polygons(rows), name="F2", positive="down")
    assert found.bounds == (2000.0, 2002.0, 0.0, 3000.0, -2800.0, -1000.0)
    with pytest.raises(InputError, match="depth or elevation"):
        gs.triangulate_fault(xtgeo.Polygons(rows), name="F2")


def test_geodataframes_are_points_and_sticks():
    geopandas = pytest.importorskip("geopandas", reason="geopandas is not installed")
    from shapely import LineString, Point

    lines = [
        LineString([(2000, y, -3000), (2000, y, -2000), (2100, y, -1000)]) for y in (0, 1500, 3000)
    ]
    fault = gs.triangulate_fault(
        geopandas.GeoDataFrame(geometry=lines, crs="EPSG:23031"), name="F2", positive="up"
    )
    assert fault.n_vertex == 9
    flat = geopandas.GeoDataFrame(geometry=[Point(0, 0)])
    refused(InputError, "no third coordinate", volumes, horizons={"Top": flat})


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (Like(vertices=np.zeros((3, 3)), faces=np.zeros((1, 4), int)), r"faces \(1, 4\)"),
        (Like(points=np.zeros((4, 3)), cells_dict={"tetra": np.zeros((1, 4))}), "takes triangles"),
    ],
)
def test_other_cells_are_refused_by_name(value, words):
    refused(InputError, words, volumes, faults={"F1": value})


def test_results_go_back():
    pv = pytest.importorskip("pyvista")
    blocks = SCENE.to_pyvista()
    assert isinstance(blocks, pv.MultiBlock)
    assert list(blocks["units"].keys()) == list(SCENE.units)
    for name, unit in SCENE.units.items():
        assert blocks["units"][name].volume == pytest.approx(unit.volume, rel=1e-6)
    assert set(blocks["horizons"].keys()) == {"Top", "Base"}
    table = SCENE.units.to_dataframe()
    assert table.volume.sum() == pytest.approx(SCENE.units.box_volume)
    assert (table.index == list(SCENE.units)).all()
    assert isinstance(SCENE.volumes, xr.DataArray)


def test_law_grids_go_to_xtgeo_and_back():
    pytest.importorskip("xtgeo", reason="xtgeo is not installed")
    top = gs.synthetic.graben(n=9).horizons["Top"]
    made = gs.to_xtgeo(top[::-1].where(top > top.min()))
    assert made.ncol == top.sizes["easting"]
    back = gs.triangulate_horizon(made, name="Top", positive="up")
    wanted = gs.triangulate_horizon(top.where(top > top.min()), name="Top")
    assert np.array_equal(np.unique(back.vertices, axis=0), np.unique(wanted.vertices, axis=0))


def test_law_surfaces_points_and_lines_go_to_xtgeo_and_back():
    pytest.importorskip("xtgeo", reason="xtgeo is not installed")
    fault = SCENE.surface("F1")
    assert_same(volumes(faults={"F1": gs.to_xtgeo(fault)}))
    sticks = gs.FaultSticks("F1", ([[0, 0, 5], [0, 9, 6]], [[9, 0, 5], [9, 9, 6], [9, 12, 7]]))
    lines = gs.to_xtgeo(sticks)
    assert lines.name == "F1"
    back = gs.triangulate_fault(lines, name="F1", positive="up")
    assert (back.vertices == gs.triangulate_fault(sticks).vertices).all()
    assert_same(volumes(faults={"F1": fault.to_pyvista()}))
    polygons = SCENE.fault_polygons("Top")
    table = gs.to_xtgeo(polygons).get_dataframe()
    assert list(table["FAULT"].unique()) == ["F1"]
    assert table["X_UTME"].tolist()[:-1] == polygons["easting"].values.tolist()
    assert len(gs.to_xtgeo([np.zeros((3, 3)), np.ones((2, 3))]).get_dataframe()) == 5
    dips = {"easting": ("point", [1.0, 2]), "northing": ("point", [3.0, 4]),
            "elevation": ("point", [5.0, 6]), "dip": ("point", [7, 8])}  # fmt: skip
    table = gs.to_xtgeo(xr.Dataset(dips)).get_dataframe()
    assert table.to_numpy().tolist() == [[1, 3, 5, 7], [2, 4, 6, 8]]


def test_fault_polygons_go_to_geopandas():
    pytest.importorskip("geopandas", reason="geopandas is not installed")
    lines = SCENE.replace(crs="EPSG:23031").fault_polygons("Top")
    table = gs.to_geodataframe(lines)
    assert table.crs.to_epsg() == 23031
    assert list(table["fault"]) == ["F1"]
    points = np.array(table.geometry.iloc[0].coords)
    assert np.array_equal(points[:-1, 0], lines["easting"].values)
    assert np.array_equal(points[0], points[-1])


def test_points_sticks_and_curves_go_to_geopandas():
    pytest.importorskip("geopandas", reason="geopandas is not installed")
    scene = SCENE.replace(crs="EPSG:23031")
    sticks = gs.FaultSticks("F1", (np.eye(3), 5 + np.eye(3)))
    assert list(gs.to_geodataframe(sticks)["name"]) == ["F1", "F1"]
    assert list(gs.to_geodataframe(scene.curves)["other"]) == ["F1", "F1"]
    names = dict(zip(("easting", "northing", "elevation"), np.eye(3), strict=True))
    points = xr.Dataset({key: ("point", value) for key, value in names.items()})
    assert [point.z for point in gs.to_geodataframe(points).geometry] == [0.0, 0.0, 1.0]


def test_tables_of_pandas_are_points_and_sticks():
    pandas = pytest.importorskip("pandas")
    corners = [(2000 + k, 1500 * i, 1000 + 900 * k) for i in range(3) for k in range(3)]
    table = pandas.DataFrame(corners, columns=["X_UTME", "Y_UTMN", "Z_TVDSS"])
    with pytest.raises(InputError, match="POLY_ID for the number of the stick"):
        gs.triangulate_fault(table, name="F1", positive="down")
    sticks = table.assign(POLY_ID=table["Y_UTMN"])
    fault = gs.triangulate_fault(sticks, name="F1", positive="down")
    assert fault.bounds == (2000.0, 2002.0, 0.0, 3000.0, -2800.0, -1000.0)
    with pytest.raises(gs.errors.SurfaceError, match=r"Use gs\.triangulate_fault"):
        gs.triangulate_sticks(sticks, name="F1")


# ---- Triangulated horizons are taken wherever triangulated faults are: files, and in feet.
def horizon_of_triangles() -> gs.TriSurface:
    return gs.TriSurface("Top", "horizon", *mesh("Top"))


@pytest.mark.parametrize("suffix", [".ts", ".obj"])
def test_files_of_meshes_build_the_same_model(suffix, tmp_path):
    top = horizon_of_triangles()
    path = gs.write(top, tmp_path / f"Top{suffix}")[0]
    found = gs.read_horizon(path, name="Top")
    assert (found.role, found.name, found.n_triangle) == ("horizon", "Top", top.n_triangle)
    np.testing.assert_allclose(volumes({"Top": path}).values, expected().values, rtol=1e-6)


def test_depths_in_feet_are_turned():
    vertices, triangles = mesh("Top")
    down = vertices * (1.0, 1.0, -1.0 / 0.3048)
    found = volumes({"Top": (down, triangles)}, positive="down", length_unit="ft")
    np.testing.assert_allclose(found.values, expected().values, rtol=1e-9)


def test_a_mesh_is_not_simplified_and_says_so():
    top = horizon_of_triangles()
    with pytest.raises(HorizonError, match=r"simplifies grids only, not meshes"):
        gs.triangulate_horizon(top, tolerance=1.0)
    refused(SurfaceError, "positive up", gs.triangulate_horizon, top, positive="down")
