"""Scenes of horizons that stay in their store: units and volumes as of grids in memory."""

from __future__ import annotations

import shutil
import warnings

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import HorizonError
from geosurf.triangulate import chunked
from geosurf.triangulate.chunked import survey_chunks

pytest.importorskip("zarr")


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    monkeypatch.setattr(chunked, "LEAST", 1)
    monkeypatch.setattr(chunked, "STAYS", 1000)


@pytest.fixture
def passes(monkeypatch):
    """Counts passes over stores."""
    names = []
    monkeypatch.setattr(
        chunked, "survey_chunks",
        lambda store, axes: names.append(store.name) or survey_chunks(store, axes),
    )  # fmt: skip
    return names


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """Two horizons that cross nowhere and are rough, in chunks of 7 x 11 nodes."""
    rng = np.random.default_rng(7)
    z = np.round(rng.normal(size=(37, 45)) * 8) - 1000
    axes = {"northing": 25.0 * np.arange(37)[::-1], "easting": 25.0 * np.arange(45)}
    attrs = {"units": "m", "positive": "up"}
    values = {"top": z, "base": z - 60 + np.round(rng.normal(size=z.shape) * 3)}
    made = xr.Dataset({k: (("northing", "easting"), v, attrs) for k, v in values.items()}, axes)
    path = tmp_path_factory.mktemp("stores") / "big.zarr"
    made.chunk({"northing": 7, "easting": 11}).to_zarr(path, consolidated=False)
    return path


@pytest.fixture
def path(store, tmp_path):
    """A store of its own for a test that changes it."""
    return shutil.copytree(store, tmp_path / "big.zarr")


def opened(path) -> dict[str, xr.DataArray]:
    data = xr.open_zarr(path, consolidated=False)
    return {"Top": data.top, "Base": data.base}


def faults() -> dict[str, gs.TriSurface]:
    two = [[0, 1, 2], [0, 2, 3]]
    f1 = [[300, -100, -2000], [400, 1100, -2000], [900, 1100, 0], [800, -100, 0]]
    # one that dies out inside: no block
    f2 = [[150, 300, -2000], [150, 500, -2000], [160, 500, 0], [160, 300, 0]]
    return {k: gs.TriSurface(k, "fault", v, two) for k, v in (("F1", f1), ("F2", f2))}


def test_law_units_and_volumes_are_those_of_grids_in_memory(path):
    lazy = gs.Scene(opened(path), faults())
    loaded = gs.Scene({k: v.compute() for k, v in opened(path).items()}, faults())
    assert lazy.volumes.identical(loaded.volumes)
    assert lazy.units.table.identical(loaded.units.table)
    assert lazy.curves.local.tobytes() == loaded.curves.local.tobytes()
    for name, unit in lazy.units.items():
        assert (unit.volume, unit.map_area) == (
            loaded.units[name].volume,
            loaded.units[name].map_area,
        )

    assert lazy.check().checks == loaded.check().checks

    # a contact and an area cut both alike
    area = [[110, 110], [900, 150], [850, 800], [120, 700]]
    change = {"contacts": {"OWC": -1030.0}, "aoi": area}
    assert lazy.replace(**change).volumes.identical(loaded.replace(**change).volumes)


@pytest.mark.parametrize("seed", [1, 2])
def test_law_horizons_that_cross_are_clipped_alike(seed):
    # small whole numbers: horizons that touch, coincide and cross
    rng = np.random.default_rng(seed)
    axes = {"northing": 25.0 * np.arange(9), "easting": 25.0 * np.arange(11)}
    grids = {
        name: xr.DataArray(
            rng.integers(-2, 3, size=(9, 11)) * 4.0 - shift,
            axes, ("northing", "easting"), attrs={"units": "m", "positive": "up"},
        )
        for name, shift in (("Top", 0.0), ("Base", 6.0))
    }  # fmt: skip
    plane = [[60, -50, -90], [120, 400, -90], [150, 400, 90], [90, -50, 90]]
    fault = gs.TriSurface("F", "fault", plane, [[0, 1, 2], [0, 2, 3]])
    lazy = {
        name: gs.triangulate_horizon(
            grid.chunk({"northing": 4, "easting": 3}), name=name, lazy=True
        )
        for name, grid in grids.items()
    }
    one, two = (gs.Scene(of, {"F": fault}) for of in (grids, lazy))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gs.GeosurfWarning)
        assert one.units.table.identical(two.units.table)
        assert one.check().checks == two.check().checks
    assert one.units.report["clipped"]
    assert repr(one.units.report) == repr(two.units.report)


def test_what_needs_all_nodes_names_the_size_and_the_remedy(path):
    scene = gs.Scene(opened(path), faults())
    words = r"'Top' stays in its store \(37 x 45 nodes.*GB\).*da\.load\(\)"
    for ask in (
        lambda: scene.orientation("Top"),
        lambda: scene.units["Top/Base F1+"].triangles,
        lambda: scene.replace(voxel_size=50.0).curves,
        lambda: scene.surface("Top").vertices,
        lambda: scene.surface("Top").triangles,
    ):
        with pytest.raises(gs.errors.HorizonError, match=words):
            ask()


def holed(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Where nodes are absent: along a rim that is no row or column, and here and there."""
    row, col = np.indices(shape)
    rim = (row + col < 4) | (row - col > shape[0] - 3) | (col > shape[1] - 2)
    return rim | (rng.random(shape) < 0.03)


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
@pytest.mark.parametrize("seed", range(6))
def test_law_absent_nodes_give_the_units_of_grids_in_memory(seed):
    # chunks without a node, holes across chunks, islands; areas and boxes proposed and given
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(9, 24, size=2).tolist())
    axes = {"northing": 25.0 * np.arange(shape[0]), "easting": 25.0 * np.arange(shape[1])}
    chunks = {k: (3, n - 3) if seed % 2 else 5 for k, n in zip(axes, shape, strict=True)}
    grids, lazy = {}, {}
    for name, shift in (("Top", 0.0), ("Base", 7.0 + 20.0 * (seed % 2))):
        z = rng.integers(-2, 3, size=shape) * 4.0 - shift
        grid = xr.DataArray(
            np.where(holed(rng, shape), np.nan, z), axes, ("northing", "easting"), name,
            {"units": "m", "positive": "up"},
        )  # fmt: skip
        grids[name] = grid
        lazy[name] = gs.triangulate_horizon(grid.chunk(chunks), name=name, lazy=True)
    plane = [[60, -50, -90], [120, 700, -90], [150, 700, 90], [90, -50, 90]]
    fault = {"F": gs.TriSurface("F", "fault", plane, [[0, 1, 2], [0, 2, 3]])}
    options = [{}, {"aoi": "rectangle"}, {"box": (60.0, 140.0, 70.0, 150.0, -90.0, 90.0)}]
    found = []
    for of in (grids, lazy):
        for option in options:
            scene = gs.Scene(of, fault, contacts={"OWC": -9.0}, **option)
            try:
                parts = [scene.units.table, scene.volumes]
                words = [scene.units.report, scene.box, scene.warnings, scene.check().checks]
            except gs.errors.OpenUnitError:  # in memory the rim is measured, too
                parts, words = [], ["leaks"]
            except gs.errors.GeosurfError as error:
                parts, words = [], [error]
            found.append((parts, repr(words)))
    for one, two in zip(found[: len(options)], found[len(options) :], strict=True):
        assert one[1] == two[1]
        assert all(p.identical(q) for p, q in zip(one[0], two[0], strict=True))


def test_no_data_values_are_refused(path):
    grids = {
        k: v.where(v.easting != 500.0, -999.25) - 5000 * (v.easting != 500.0)
        for k, v in opened(path).items()
    }
    with pytest.raises(gs.errors.HorizonError, match=r"-999\.25 m, a usual no-data value"):
        _ = gs.Scene(grids, faults()).curves


def test_bounds_are_kept_beside_the_store_until_it_changes(path, passes):
    def elevations() -> tuple[float, ...]:
        surfaces = (gs.triangulate_horizon(v, name=k) for k, v in opened(path).items())
        return tuple(end for one in surfaces for end in one.bounds[4:])

    first = elevations()
    files = sorted(path.parent.glob("*.geosurf-bounds"))
    names = [f"big.zarr.{name}.geosurf-bounds" for name in ("Base", "Top")]
    assert [file.name for file in files] == names
    assert passes == ["Top", "Base"]
    assert elevations() == first
    assert len(passes) == 2

    # damage: made again
    files[1].write_bytes(files[1].read_bytes()[:-9])
    assert elevations() == first
    assert passes[2:] == ["Top"]

    # files with other content: made again
    data = xr.open_zarr(path, consolidated=False).compute()
    lower = (data.base - 10.0).to_dataset(name="base").chunk({"northing": 7, "easting": 11})
    lower.to_zarr(path, mode="r+", consolidated=False)
    assert elevations() == (*first[:2], first[2] - 10.0, first[3] - 10.0)
    assert passes[3:] == ["Base"]  # another variable of the store is as it was

    # other values of the same files
    assert gs.triangulate_horizon(-opened(path)["Top"], name="Top").bounds[4] == -first[1]


@pytest.mark.parametrize(("column", "result"), [("1", "volumes"), ("2", "curves")])
def test_chunks_that_are_gone_are_an_error(path, column, result):
    # the first one where no curve is
    scene = gs.Scene(opened(path), faults())
    _ = scene.surface("Top")
    for file in (path / "top" / "c").glob(f"[0-9]/{column}"):
        file.unlink()
    with pytest.raises(
        gs.errors.HorizonError, match=r"'Top'.*(that were there when the store|have changed since)"
    ):
        getattr(scene, result)


def test_stores_that_are_read_only_use_the_cache(path, passes, monkeypatch, tmp_path):
    from geosurf.triangulate import chunk_files

    write = chunk_files.write_whole

    def refuse(target, *rest):
        if target.parent == path.parent:
            raise PermissionError(13, "read-only")
        write(target, *rest)

    monkeypatch.setattr(chunk_files, "write_whole", refuse)
    monkeypatch.setattr(chunk_files, "cache_root", lambda: tmp_path / "cache")
    for _ in range(2):
        for name, grid in opened(path).items():
            gs.triangulate_horizon(grid, name=name)
    assert passes == ["Top", "Base"]
    assert len(list((tmp_path / "cache" / "bounds").iterdir())) == 2


def test_small_dask_arrays_are_read_as_before(path, monkeypatch):
    monkeypatch.setattr(chunked, "STAYS", 1 << 26)
    scene = gs.Scene(opened(path), faults())
    assert scene.thickness("Top/Base").size > 0
    assert not list(path.parent.glob("*.geosurf-bounds"))


def test_law_netcdf_stores_give_the_bytes_of_grids_in_memory(path, passes, tmp_path):
    pytest.importorskip("h5netcdf")
    file = tmp_path / "big.nc"
    xr.open_zarr(path, consolidated=False).compute().to_netcdf(file, engine="h5netcdf")

    def lazy() -> gs.Scene:
        data = xr.open_dataset(file, engine="h5netcdf", chunks={"northing": 7, "easting": 11})
        return gs.Scene({"Top": data.top, "Base": data.base}, faults())

    loaded = gs.Scene({k: v.compute() for k, v in opened(path).items()}, faults())
    for _ in range(2):  # the second one finds the bounds beside the file
        scene = lazy()
        assert scene.units.table.identical(loaded.units.table)
        assert scene.curves.local.tobytes() == loaded.curves.local.tobytes()
    assert passes == ["Top", "Base"]
    names = [f"big.nc.{name}.geosurf-bounds" for name in ("Base", "Top")]
    assert sorted(one.name for one in tmp_path.glob("*.geosurf-bounds")) == names


def test_results_are_not_of_two_states_of_a_store(path):
    zarr = pytest.importorskip("zarr")
    at = np.array([[500.0, 400.0, -1030.0]])
    results = {
        "units": (lambda scene: scene.curves, lambda scene: scene.units),
        "thickness": (lambda scene: scene.units, lambda scene: scene.thickness("Top/Base", 100.0)),
        "sample": (lambda scene: scene.sample(at + 9.0), lambda scene: scene.sample(at)),
        "check": (lambda scene: scene.units, lambda scene: scene.check()),
    }
    for name, (before, after) in results.items():
        scene = gs.Scene(opened(path))
        before(scene)

        # others in the store may change
        group = zarr.open_group(path, mode="r+")
        group.create_array("other", data=np.zeros(3), dimension_names=["k"], overwrite=True)
        assert scene.patches.n_patch, name
        group["top"][15, 20] += 1.0  # no curve is near
        with pytest.raises(HorizonError, match=r"'Top': its files in .* have changed since"):
            after(scene)
        assert scene.patches.n_patch  # what is known stays


def test_an_error_of_a_store_that_changes_names_the_change(path):
    zarr = pytest.importorskip("zarr")
    world = gs.synthetic.tilted_planes(n=5)
    fault = gs.triangulate_fault(world.faults["F1"], name="F1")
    fault = gs.TriSurface(
        "F1", "fault", fault.vertices * [0.2, 0.3, 1.0] + [0.0, 0.0, 1000.0], fault.triangles
    )
    scene = gs.Scene(opened(path), {"F1": fault})
    assert scene.curves.n_curve
    zarr.open_group(path, mode="r+")["top"][10:30, 10:30] += 30.0
    with pytest.raises(HorizonError, match="have changed since"):
        _ = scene.volumes
