"""A scenario, run: each stage in its turn, then everything written at once."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geosurf.conventions.machine import (
    DRAWING,
    is_installed,
    missing_sentence,
    need_plots,
    warning_without_pictures,
)
from geosurf.errors import DependencyError, warn
from geosurf.measure.volumetrics import totals_in_words
from geosurf.model import Certificate
from geosurf.model.column import CONFORMABLE
from geosurf.model.distributions import medians
from geosurf.model.expected import flag_of
from geosurf.read import read_points, read_polygons
from geosurf.report import report_scene
from geosurf.scenario.build import build_scene, units_of_bodies
from geosurf.scenario.keys import Scenario
from geosurf.scenario.output import (
    NO_NETCDF,
    VOLUMETRICS,
    draw_grid,
    in_words,
    input_files,
    new_results,
    refuse_lists,
    wells_of_scenario,
    without_lists,
    writable_formats,
    write_files,
    write_grid,
    write_wells,
)
from geosurf.scenario.output_keys import OutputSettings
from geosurf.scenario.step_log import Progress, StepLog
from geosurf.scenario.validate import read_scenario
from geosurf.scene import Scene
from geosurf.scene.result_cache import ResultCache, cache_in, check_with_cache
from geosurf.write import write
from geosurf.write.written import commit

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.render.overlay import PictureOverlay
    from geosurf.render.picture_style import PictureStyle

# ---- pictures ----------------------------------------
# The pictures that a scenario asks for.


def will_draw(scenario: Scenario, pictures: bool | None) -> bool:
    """
    Return whether a run draws pictures.

    Parameters
    ----------
    scenario : Scenario
    pictures : bool or None
        None draws where matplotlib is installed.

    Raises
    ------
    DependencyError
        If the caller or the scenario asks for pictures that cannot be drawn here.
    """
    if pictures is None:
        asked, missing = asked_for(scenario), missing_sentence("they need", *DRAWING)
        if asked and missing:
            raise DependencyError(
                f"{scenario.path}: {asked} asks for pictures, and {missing}; or run it with "
                "--no-pictures (pictures=False)."
            )
        return is_installed("matplotlib")
    if flag_of(pictures, "pictures"):
        need_plots()
    return pictures


def asked_for(scenario: Scenario) -> str:
    """Return the first key of a scenario that asks for pictures which are not drawn anyway."""
    output, usual = scenario.output, OutputSettings()
    for word in ("views", "search", "sections_m"):
        value = getattr(output, word)
        if value and value != getattr(usual, word):
            return f"output.{word}"
    return "" if scenario.pictures.camera is None else "pictures.camera"


def choice_of_pictures(scenario: Scenario) -> dict[str, Any]:
    """Return what `Scene.render_pictures` takes for the pictures that a scenario asks for."""
    # Keys of the scenario have units in their names, arguments of the scene do not.
    output, pictures = scenario.output, scenario.pictures
    alike = ("views", "exploded", "maps", "thickness", "allan", "throw", "search", "clip")
    return {
        **{key: getattr(output, key) for key in (*alike, "exaggeration", "include")},
        **{key: getattr(pictures, key) for key in ("camera", "zoom", "colour_by")},
        "sections": output.sections_m,
        "size": output.size_px,
        "only": pictures.only or None,
        "style": picture_style(scenario),
        "overlay": overlay_of_files(scenario),
    }


def picture_style(scenario: Scenario) -> PictureStyle:
    """Return the style of all pictures, which show depths where the inputs are depths."""
    depth = "depth" if scenario.positive == "down" else None
    return replace(scenario.pictures.style, vertical=depth)


def overlay_of_files(scenario: Scenario) -> PictureOverlay:
    """Read the wells, polygons and data points of a scenario.

    Raises
    ------
    InputError
        If a file cannot be read, or it does not state whether z is depth and the scenario neither.
    """
    from geosurf.render.overlay import PictureOverlay  # loaded by those who draw

    known: dict[str, Any] = {"positive": scenario.positive, "length_unit": scenario.length_unit}
    pictures = scenario.pictures
    return PictureOverlay(
        wells=wells_of_scenario(scenario),
        polygons={
            name: read_polygons(file, **known) for name, file in (pictures.polygons or {}).items()
        },
        points={name: read_points(file, **known) for name, file in (pictures.points or {}).items()},
    )


# ---- notes ----------------------------------------
# Notes of a run: what a user should look at in the model.


def model_notes(scene: Scene) -> list[str]:
    """Return what a user should look at: in torn horizons, in the column, in fluid contacts."""
    # Notes are for people: what is a warning already is printed once.
    torn = [
        f"horizon {name!r}: {note}"
        for name, sheet in scene.sheets.items()
        for note in sheet.report.notes
        if note not in map(str, sheet.warnings)  # those are printed as warnings
    ]
    return [*torn, *crossings(scene), *contacts_left_out(scene)]


def crossings(scene: Scene) -> list[str]:
    """Return a note on each pair of conformable horizons that cross: no rule allows it."""
    # Crossings that a rule of the column explains are intended.
    return [
        f"{clip}. If this is not intended, list horizons youngest first, or set their rules."
        for clip in scene.units.report["clipped"]
        if clip.rule == CONFORMABLE
    ]


def contacts_left_out(scene: Scene) -> list[str]:
    """Return a note on each fluid contact that is given for some blocks, and not for others."""
    notes = []
    # A few units are named, the rest counted: blocks may be many.
    for name, left in scene.units.report["without_contact"].items():
        more = f" and {len(left) - 6} more" if len(left) > 6 else ""
        notes.append(
            f"fluid contact {name!r} does not split {', '.join(left[:6])}{more}: it is not given "
            "for their blocks. If this is not intended, add a table for these blocks, or one "
            "without a block."
        )
    return notes


@dataclass(frozen=True)
class Outcome:
    """The result of a run.

    Attributes
    ----------
    scene : Scene
    certificate : Certificate
    out : pathlib.Path
        The folder with all files.
    notes : tuple of str
        What to look at: notes of torn horizons, conformable horizons that cross (often a wrong
        order), and fluid contacts that are not given for some blocks.
    """

    scene: Scene
    certificate: Certificate
    out: Path
    notes: tuple[str, ...]


def run_scenario(
    path: str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    pictures: bool | None = None,
    progress: Progress | None = None,
    cache_dir: str | os.PathLike[str] | None = None,
) -> Scene:
    """
    Run a scenario and write everything that it asks for.

    Parameters
    ----------
    path : path-like
        The scenario, a TOML file; docs/scenario.md has its keys.
    out : path-like
        A folder, created if needed, for ``units.vtm`` (and the folder ``units``),
        ``curves.vtp``, ``volumes.csv``, ``volumes.nc``, ``certificate.txt``,
        ``pictures/*.png`` and ``report/index.html``. Results of an earlier run
        are replaced as a whole; files under other names stay. A picture that cannot be drawn costs
        no other result: a `GeosurfWarning` names it.
    pictures : bool, optional
        False draws none. By default pictures are drawn where matplotlib is installed; elsewhere a
        `GeosurfWarning` states it once.
    progress : callable, optional
        Is called with a line of text after each step.
    cache_dir : path-like, optional
        A folder in which torn horizons, certificates and pictures are stored, and found again by
        later runs with the same inputs. Results have the same bytes with and without it, except the
        run log in the report.

    Returns
    -------
    Scene
        With all its results in memory.

    Raises
    ------
    ScenarioError
        If the scenario has an unknown key or an impossible value.
    DependencyError
        If pictures are wanted, by ``pictures=True`` or by a key of ``[output]``, and what draws
        them is not installed.
    OutputError
        If the folder cannot be written; found out before anything is computed.
    InputError, GeometryError
        If a surface cannot be read, or the surfaces do not bound units; where that is
        at one place and pictures are wanted, ``failure.png`` in ``out`` shows it.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import geosurf as gs
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> top = gs.synthetic.tilted_planes(n=5).horizons["Top"]
    >>> _ = gs.write(top, folder / "Top.nc")
    >>> _ = (folder / "scenario.toml").write_text('''
    ... [[horizons]]
    ... name = "Top"
    ... file = "Top.nc"
    ... ''')
    >>> scene = run_scenario(folder / "scenario.toml", folder / "out", pictures=False)
    >>> list(scene.units)
    ['above Top', 'below Top']
    >>> (folder / "out" / "volumes.csv").is_file()
    True
    """
    outcome = run(
        read_scenario(path), out, pictures=pictures, progress=progress, cache_dir=cache_dir
    )
    return outcome.scene


def run(
    scenario: Scenario,
    out: str | os.PathLike[str],
    *,
    pictures: bool | None = None,
    report: bool = True,
    progress: Progress | None = None,
    cache_dir: str | os.PathLike[str] | None = None,
) -> Outcome:
    """Run a scenario that has been read; see `run_scenario`.

    Parameters
    ----------
    scenario : Scenario
    out : path-like
    pictures : bool, optional
    report : bool
        False writes no report.
    progress : callable, optional
    cache_dir : path-like, optional

    Returns
    -------
    Outcome
        Also with the certificate and notes.
    """
    # arguments and formats are checked before the first file is read
    log = StepLog(progress)
    asked = scenario
    scenario = writable_formats(scenario)
    wells = wells_of_scenario(scenario)
    choice = choice_of_pictures(scenario) if will_draw(scenario, pictures) else None
    cache = cache_in(cache_dir)

    # all results appear together at the end, or those of the run before stay
    with new_results(out) as folder:
        scene = compute(scenario, log, None if choice is None else Path(out), cache)
        fluids = fluids_of(scenario, scene, log)
        certificate = check_with_cache(scene, cache)
        log.step("check", "certificate", "valid" if certificate.ok else "FAILED")
        if scenario is not asked:
            with scene._graph.memory.collecting():
                warn(NO_NETCDF)
        scenario = without_lists(scenario, scene)
        write_files(scene, scenario, folder)
        if fluids is not None:
            write(fluids, folder / VOLUMETRICS)
        listed = ", ".join([*scenario.output.formats, *write_wells(scene, wells, folder)])
        log.step("write", listed, "")

        grid, stepped = None, list[str]()
        if scenario.grid is not None:
            grid, stepped = write_grid(scene, scenario.grid, scenario.seal, folder)
            log.step("grid", "grid.grdecl, grid.inc", in_words(grid))

        # pictures may warn, and the certificate lists warnings: it is written after them
        drawn = _draw(scene, choice, folder, log, asked=pictures)
        if grid is not None and choice is not None:
            drawn |= draw_grid(grid, folder / "pictures")
        _write_certificate(scene, scenario, certificate, folder)
        notes = [*model_notes(scene), *stepped]

        # last, with the pictures that could be drawn
        if report:
            _write_report(scene, scenario, folder / "report", drawn, certificate, fluids)
            log.step("report", scenario.title)
    return Outcome(scene, certificate, Path(out), tuple(notes))


def _write_report(
    scene: Scene,
    scenario: Scenario,
    folder: str | os.PathLike[str],
    drawn: dict[str, Path],
    certificate: Certificate,
    fluids: Any,
) -> Path:
    """Write the page into a folder."""
    return report_scene(
        scene,
        folder,
        drawn,
        title=scenario.heading,
        certificate=certificate,
        regions=_regions(scenario, scene),
        inputs=input_files(scenario),
        relative_to=scenario.path.parent,
        include=scenario.output.include,
        volumetrics=fluids,
    )


def fluids_of(scenario: Scenario, scene: Scene, log: StepLog) -> Any:
    """Return what ``[volumetrics]`` asks for, and log the totals."""
    if scenario.volumetrics is None:
        return None
    given = medians(vars(scenario.volumetrics))
    volumes = scene.volumetrics(**given, include=scenario.output.include)
    at = "" if given == vars(scenario.volumetrics) else "; at medians of distributions"
    log.step("volumetrics", "reservoir", totals_in_words(volumes) + at)
    return volumes


def compute(
    scenario: Scenario, log: StepLog, out: Path | None = None, cache: ResultCache | None = None
) -> Scene:
    """Read the inputs and run all stages up to the units, with a line of the log for each step.

    A picture of the place where the model cannot be built goes into the folder ``out``.
    """
    scene = build_scene(scenario, log, cache)
    with log.watching(scene, out):
        for name in (*scene.horizon_names, *scene.fault_names):
            scene.whole_surface(name)
        refuse_lists(scenario, scene)
        # each stage is a property of the scene; reading it runs what is missing
        _ = scene.curves, scene.coverage, scene.units
    return scene


def _regions(scenario: Scenario, scene: Scene) -> dict[str, tuple[float, str]]:
    """Volumes of the regions of a sealed model that came from a file, and the units there."""
    if scenario.model is None:
        return {}
    from geosurf.read.model3d import read_region_faces, volume_with_sign

    model = scenario.model

    # regions are bodies of the other program; a point inside finds the unit that holds each
    shells = read_region_faces(model.file, positive=model.positive, length_unit=model.length_unit)
    holding = units_of_bodies(shells, scene.units)
    return {name: (abs(volume_with_sign(shell)), holding[name]) for name, shell in shells.items()}


def _draw(
    scene: Scene, choice: dict[str, Any] | None, folder: Path, log: StepLog, *, asked: bool | None
) -> dict[str, Path]:
    """Captions and files of the pictures asked for; `scene.warnings` has what is missing."""
    if choice is None:
        if asked is None and (note := warning_without_pictures()) is not None:
            with scene._graph.memory.collecting():
                warn(note)
        return {}
    # A picture that fails is a warning, and the run goes on.
    return scene.render_pictures(folder, on_file=lambda file: log.step("draw", file), **choice)


def _write_certificate(
    scene: Scene, scenario: Scenario, certificate: Certificate, folder: Path
) -> None:
    """Write the certificate, when all that can be warned of has been."""
    # the certificate is read alone: what it rests on stands above it
    warnings = "".join(f"Warning: {warning}\n" for warning in scene.warnings)
    lines = "\n".join(filter(None, [f"{scenario.heading}\n", warnings, f"{certificate}\n"]))
    commit(folder / "certificate.txt", lines.encode("utf-8"))
