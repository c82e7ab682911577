"""The writers that `crash_points` attacks: old results, new results, and what counts as ours."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path, PurePosixPath

import geosurf as gs
from geosurf import files
from geosurf.files import write_into_folder
from geosurf.kernels.compile import file_cache
from geosurf.scenario import execute, output
from geosurf.write import WRITERS as FORMATS

Action = Callable[[Path], object]


@dataclass(frozen=True)
class Writer:
    """A writer, by what it does in an empty folder first and then again."""

    name: str
    write_old: Action
    write_new: Action
    may_be_unfinished: bool = False
    silent: bool = False  # trouble is no error
    is_ours: Callable[[str], bool] = lambda name: True
    marked: Callable[[dict[str, str]], bool] = lambda found: False


# ---- one file -----------------------------------------------------------------------------


@cache
def scenes():
    """An old scene with faults, and a new one without, so with fewer units."""
    world = gs.synthetic.graben(n=11)
    found = []
    for faults in (world.faults, {}):
        scene = gs.Scene(world.horizons, faults, world.box, crs="EPSG:32631")  # as GeoJSON asks
        scene.check()
        _ = scene.units.table
        found.append(scene)
    return tuple(found)


def surface(k: int) -> gs.TriSurface:
    """A fault that differs with `k`."""
    return gs.TriSurface("F1", "fault", [[0, 0, k], [9, 0, 0], [0, 9, 9]], [[0, 1, 2]])


@cache
def thing(kind: str, k: int) -> object:
    """An object of a kind that `write` takes."""
    scene = scenes()[k]
    if kind == "horizon (DataArray)":
        horizon = gs.synthetic.graben(n=5).horizons["Top"]
        return horizon + 10.0 * k if not k else horizon.copy(data=horizon.values + 10.0)
    made = {
        "TriSurface": lambda: surface(k),
        "Curves": lambda: scenes()[0].curves if not k else gs.Scene(
            {"Top": gs.synthetic.graben(n=5).horizons["Top"]},
            {"F1": scenes()[0].surface("F1")}, scene.box).curves,
        "Patches": lambda: scene.patches,
        "Unit": lambda: next(iter(scene.units.values())),
        "Units": lambda: scene.units,
    }  # fmt: skip
    return made[kind]()


def single(kind: str, suffix: str) -> Writer:
    """`gs.write` of something to one file."""
    here = f"x{suffix}"
    return Writer(
        f"write {kind.split()[0]} {suffix}",
        lambda place: gs.write(thing(kind, 0), place / here),
        lambda place: gs.write(thing(kind, 1), place / here),
    )


KINDS = ("TriSurface", "Curves", "Patches", "Unit", "Units", "horizon (DataArray)")
# sets of several files are no single file; Parquet only where its package is
LEFT_OUT = {".vtm", ".epc"} | ({".parquet"} if find_spec("pyarrow") is None else set())
SINGLE = [single(k, s) for k in KINDS for s in FORMATS[k] if s not in LEFT_OUT]


def _keep(k: int) -> Action:
    def save(place: Path) -> None:
        os.environ["GEOSURF_CACHE_DIR"] = str(place)  # in a child process
        place.chmod(0o700)
        file_cache._reported.append(None)  # trouble is expected
        file_cache.Store("kernels").save("kernel-1.nbc", bytes([k]) * 9000)

    return save


def _with(write: Callable[[Path, int], object]) -> tuple[Action, Action]:
    """The old and the new result of a writer that takes a number."""
    return lambda place: write(place, 0), lambda place: write(place, 1)


@cache
def blocks(k: int) -> object:
    """A block model; the second one has other cells."""
    return scenes()[k].sample(cell=(1000, 1000, 200 + 100 * k), codes=True)


OTHERS = [
    Writer("picture", *(_with(lambda place, k: write_into_folder(
        place / "a.png", bytes([k]) * 5000, "the picture")))),
    Writer("report", *(_with(lambda place, k: gs.report_scene(scenes()[k], place, {})))),
    Writer("block model .zarr", *(_with(lambda place, k: gs.write(blocks(k), place / "b.zarr"))),
           may_be_unfinished=True, marked=lambda found: not found),
    Writer("kernel cache", _keep(1), _keep(2), silent=True),
]  # fmt: skip


# ---- many files ---------------------------------------------------------------------------


def _units(k: int) -> Action:
    def write(place: Path) -> None:
        (place / "u").mkdir(exist_ok=True)
        (place / "u" / "mine.vtp").write_text("mine")
        gs.write(scenes()[k].units, place / "u.vtm")

    return write


VTM = Writer(
    "write Units .vtm", _units(0), _units(1), True,
    is_ours=lambda name: name != "u/mine.vtp", marked=lambda found: "u.vtm" not in found,
)  # fmt: skip


@cache
def scenario() -> execute.Scenario:
    """Any scenario: what it computes is replaced."""
    folder = Path(tempfile.mkdtemp())
    gs.write(gs.synthetic.graben(n=5).horizons["Top"], folder / "Top.nc")
    text = '[[horizons]]\nname = "Top"\nfile = "Top.nc"\n[output]\nformats = {}\n'
    (folder / "s.toml").write_text(text.format('["vtm", "vtp", "csv"]'))
    return execute.read_scenario(folder / "s.toml")


@contextmanager
def computed(k: int) -> Iterator[None]:
    """Runs compute nothing: the scene is there."""
    before = execute.compute
    execute.compute = lambda *words: scenes()[k]
    try:
        yield
    finally:
        execute.compute = before


def _run(k: int, notes: bool = False, inside: bool = False) -> Action:
    def run(place: Path) -> None:
        if notes and not (place / "notes.txt").exists():
            (place / "units").mkdir(exist_ok=True)
            for name in ("notes.txt", "units/mine.vtp"):
                (place / name).write_text("mine")
        if inside:
            os.chdir(place)
        with computed(k):
            execute.run(scenario(), "." if inside else place, pictures=False)

    return run


def _runs(name: str, **how: bool) -> Writer:
    return Writer(
        name, _run(0, **how), _run(1, **how), True,
        is_ours=lambda name: PurePosixPath(name) in output.OURS,
        marked=lambda found: files.MARK in found,
    )  # fmt: skip


RUNS = [
    _runs("run"),
    _runs("run beside foreign files", notes=True),
    _runs("run where one stands", inside=True),
]


def warm() -> None:
    """Compute, compile and import once what all child processes need."""
    scenario()
    for kind in KINDS:
        thing(kind, 0), thing(kind, 1)
    for k in (0, 1):
        blocks(k)
    with tempfile.TemporaryDirectory() as name:
        for writer in [*SINGLE, OTHERS[1], VTM, RUNS[0]]:
            writer.write_old(Path(name))


WRITERS = [*SINGLE, *OTHERS, VTM, *RUNS]
