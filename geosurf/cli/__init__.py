"""The command line: ``geosurf run scenario.toml -o out/``.

Nothing heavy is imported before a command runs, so that ``geosurf --help`` answers
at once. Errors that geosurf raises on purpose are printed without a traceback and
end with their exit code: 2 input, 3 geometry, 4 our own fault.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import geosurf
from geosurf.cli.console import encodable_output, printed_warnings
from geosurf.cli.exit_codes import OUR_FAULT, Ending
from geosurf.errors import FormatError, InputError

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.model import Certificate
    from geosurf.scenario.keys import Scenario

BROKEN_PROMISE = 3
VIEW, SHOW = "southwest", "horizons,faults,curves"
EXIT_CODES = """exit codes: 0 done, 2 the input cannot be used, 3 the geometry is impossible or a
promise is not kept, 4 a fault of geosurf, 128 + n stopped by signal n (Ctrl-C: 130)"""


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run a command and return its exit code.

    Parameters
    ----------
    argv : sequence of str, optional
        Default: the arguments of the process.

    Returns
    -------
    int

    Examples
    --------
    >>> main(["check", "missing.toml"])
    2
    """
    with encodable_output():
        options = build_parser().parse_args(argv)
        ending = Ending(options.debug)
        with ending, printed_warnings():
            ending.code = options.run(options)
            if sys.stdout is not None:  # closed from the beginning
                sys.stdout.flush()
    return ending.code


# ---- the commands ----------------------------------------------------------------------


def run_command(options: argparse.Namespace) -> int:
    """Run a scenario and write everything."""
    from geosurf.report.table import as_plain_text
    from geosurf.report.tables import volume_table
    from geosurf.scenario import read_scenario, run

    say = _speaker(options.quiet)
    start = time.perf_counter()
    scenario = read_scenario(options.scenario)
    outcome = run(scenario, options.out, pictures=not options.no_pictures, progress=say)
    for note in outcome.notes:
        print(f"geosurf: {note}", file=sys.stderr)
    if not options.quiet:
        table = volume_table(outcome.scene.units)
        print(f"\n{as_plain_text(table, 'Volumes [million m3]')}\n")
        print(f"{len(outcome.scene.units)} units in {time.perf_counter() - start:.1f} s.")
        print(f"Report: {outcome.out / 'report' / 'index.html'}; everything else beside it.")
    return _verdict(outcome.certificate)


def check_command(options: argparse.Namespace) -> int:
    """Print the certificate of a scenario."""
    from geosurf.scenario import build_scene, read_scenario

    certificate = build_scene(read_scenario(options.scenario)).check()
    print(certificate)
    return _verdict(certificate)


def render_command(options: argparse.Namespace) -> int:
    """Draw one picture of a scenario."""
    from geosurf.render.compose import png_path
    from geosurf.scenario import read_scenario

    scenario = read_scenario(options.scenario)
    png_path(options.out)  # before anything is computed
    draw = _draw_view if options.section is None else _draw_section
    print(draw(scenario, options))
    return 0


def _draw_view(scenario: Scenario, options: argparse.Namespace) -> Path:
    """Draw what is asked for in space; what is not said is as in the scenario."""
    from geosurf.render import render_scene
    from geosurf.scenario import build_scene

    def given(option: Any, otherwise: Any) -> Any:
        """An option, or what is meant without it."""
        return otherwise if option is None else option

    return render_scene(
        build_scene(scenario),
        options.out,
        view=given(options.view, VIEW),
        show=tuple(word.strip() for word in given(options.show, SHOW).split(",")),
        size=scenario.output.size_px,
        exaggeration=given(options.exaggeration, scenario.output.exaggeration),
        clip=given(options.clip, scenario.output.clip),
    )


def _draw_section(scenario: Scenario, options: argparse.Namespace) -> Path:
    """Draw a vertical section; options of views are refused, since they would do nothing."""
    from geosurf.render import render_section
    from geosurf.scenario import build_scene

    for word in ("view", "show", "exaggeration", "clip"):
        if getattr(options, word) is not None:
            raise InputError(
                f"--section draws a vertical section, which has no --{word}; leave one of them out."
            )
    line = _line_of(options.section)
    section = build_scene(scenario).section(line)
    return render_section(section, options.out, size=scenario.output.size_px)


def _line_of(text: str) -> list[tuple[float, float]]:
    """Points of a line in the map from words as in ``0,2500 6000,2500``."""
    line = []
    for word in text.split():
        try:
            east, north = map(float, word.split(","))
        except ValueError as error:
            raise InputError(
                f"--section: {word!r} is no point; give easting and northing [m] of two points or "
                'more in quotes, as in "0,2500 6000,2500".'
            ) from error
        line.append((east, north))
    return line


def report_command(options: argparse.Namespace) -> int:
    """Write the report of a scenario."""
    from geosurf.scenario import read_scenario
    from geosurf.scenario.execute import write_report

    scenario = read_scenario(options.scenario)
    certificate, path, notes = write_report(
        scenario, options.out, pictures=not options.no_pictures, progress=_speaker(options.quiet)
    )
    for note in notes:
        print(f"geosurf: {note}", file=sys.stderr)
    print(path)
    return _verdict(certificate)


def curves_command(options: argparse.Namespace) -> int:
    """Find the curves of two surface files."""
    from geosurf.conventions import counted
    from geosurf.intersect import intersect_surfaces
    from geosurf.write import write

    words = {"positive": options.positive, "length_unit": options.length_unit}
    surfaces = [_surface(Path(path), words) for path in (options.first, options.second)]
    if surfaces[0].name == surfaces[1].name:
        surfaces = [surfaces[0].renamed(options.first), surfaces[1].renamed(options.second)]
    curves = intersect_surfaces(surfaces)
    closed = int(curves.closed.sum())
    for path in write(curves, options.out):
        print(f"{path}: {counted(curves.n_curve, 'curve')}, {closed} closed, {curves.length:.3f} m")
    points = sum(contact.kind == "point" for contact in curves.contacts)
    if points:
        print(f"The surfaces touch in {counted(points, 'point')}, too.")
    if len(curves.contacts) > points:
        area = sum(contact.area for contact in curves.contacts)
        print(f"They coincide over {area:.3f} m2; curves go around that area.")
    return 0


def doctor_command(options: argparse.Namespace) -> int:
    """Say what geosurf stands on here."""
    from geosurf.render import doctor

    findings = doctor()
    for name, fit, sentence in findings:
        print(f"{'ok  ' if fit else 'LACK'}  {name:<9} {sentence}")
    return 0 if all(fit for _, fit, _ in findings) else InputError.exit_code


def warmup_command(options: argparse.Namespace) -> int:
    """Compile all kernels, so that the next command does not have to."""
    from geosurf.kernels.compile.warmup import warm

    show = sys.stdout.isatty()

    def progress(n_done: int, n_file: int) -> None:
        """Show how many files are done, on one line."""
        print(f"\r{n_done} of {n_file} files of kernels", end="", flush=True)

    done = warm(progress if show else None)
    print(f"\r{done}" if show else done)
    return 0


def stress_command(options: argparse.Namespace) -> int:
    """Feed the engine what breaks engines, and judge its answers."""
    from geosurf.prove.stress import replay, run_stress, write_json

    if options.replay:
        case, outcome = replay(options.replay)
        print(f"{case.family} {case.number}, seed {case.seed}: {len(outcome.wrong)} wrong")
        for sentence in (*outcome.wrong, *filter(None, [outcome.refused])):
            print(f"  {sentence}")
        return OUR_FAULT if outcome.wrong else 0
    keep = Path(options.out).parent / "stress_failures" if options.out else "stress_failures"
    start = time.perf_counter()
    rows = run_stress(
        options.cases, options.seed, options.family, keep=keep, progress=_speaker(options.quiet)
    )
    count, wrong, refused = (
        sum(getattr(r, k) for r in rows) for k in ("cases", "wrong", "refused")
    )
    seconds = time.perf_counter() - start
    print(f"{count} cases, {wrong} wrong, {refused} refused, {seconds:.1f} s, seed {options.seed}.")
    if options.out:
        print(write_json(rows, options.out, seed=options.seed, cases=options.cases))
    for row in rows:
        for failure in row.failures[:3]:
            print(f"{row.family} {failure['number']}: {failure['wrong'][0]}", file=sys.stderr)
            print(f"  geosurf stress --replay {failure['file']}", file=sys.stderr)
    return OUR_FAULT if wrong else 0


# ---- what they share -------------------------------------------------------------------


def _speaker(quiet: bool) -> Callable[[str], object] | None:
    return None if quiet else lambda line: print(line, flush=True)


def _verdict(certificate: Certificate) -> int:
    """Return 0, or name the promises that are not kept."""
    broken = [f"{check.name} ({check.detail})" for check in certificate.checks if not check.passed]
    if not broken:
        return 0
    print(
        f"geosurf: not kept: {'; '.join(broken)}. Look at these places before using the model.",
        file=sys.stderr,
    )
    return BROKEN_PROMISE


def _surface(path: Path, words: dict[str, str | None]) -> Any:
    """Read one surface; the suffix tells horizons from faults, in NetCDF its dimensions do."""
    from geosurf.read import FAULT_FORMATS, GRID_FORMATS, otherwise, read_fault, read_nodes
    from geosurf.read.netcdf import holds_fault
    from geosurf.triangulate import triangulate_fault, triangulate_horizon

    suffix = path.suffix.lower()
    formats = (*GRID_FORMATS.values(), *FAULT_FORMATS.values())
    known = {word for _, _, suffixes in formats for word in suffixes}
    if suffix not in known:
        missing = "" if path.exists() else " and there is no such file"
        raise FormatError(
            f"{path}: no surface has the suffix {path.suffix!r}{missing}; known are "
            f"{', '.join(sorted(known))}. Rename the file, or save it as one of these."
        )
    gridded = any(suffix in suffixes for _, _, suffixes in GRID_FORMATS.values())
    if suffix in GRID_FORMATS["netcdf"][2]:
        gridded = not holds_fault(path)
    if gridded:
        return triangulate_horizon(read_nodes(path, **otherwise(words)), name=path.stem)
    found = read_fault(path, **otherwise(words))
    return found if hasattr(found, "triangles") else triangulate_fault(found, name=path.stem)


# ---- the words -------------------------------------------------------------------------


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of all commands and options.

    Returns
    -------
    argparse.ArgumentParser
    """
    parser = argparse.ArgumentParser(
        prog="geosurf",
        description="Horizons and faults in; sealed, exact, certified reservoir units out.",
        epilog=EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"geosurf {geosurf.__version__}")
    parser.add_argument("--debug", action="store_true", help="show the traceback of an error")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)

    def add(name: str, run: Callable[[argparse.Namespace], int], help_: str) -> Any:
        """A command with the options that all of them have."""
        command = commands.add_parser(name, help=help_, description=help_)
        command.set_defaults(run=run)
        # without a default here, so that `geosurf --debug run` is not undone by `run`
        command.add_argument(
            "--debug",
            action="store_true",
            default=argparse.SUPPRESS,
            help="show the traceback of an error",
        )
        return command

    run = add("run", run_command, "build the model of a scenario: volumes, pictures, a report")
    check = add("check", check_command, "print the certificate of a scenario; 3 if one fails")
    render = add("render", render_command, "draw one picture of a scenario")
    report = add("report", report_command, "write the report of a scenario, and its pictures")
    for command in (run, check, render, report):
        command.add_argument("scenario", help="a TOML file; docs/scenario.md has its keys")
    for command in (run, report):
        command.add_argument("-o", "--out", required=True, help="folder, created if need be")
        command.add_argument("--no-pictures", action="store_true", help="draw nothing")
        command.add_argument("--quiet", action="store_true", help="no progress")
    render.add_argument("-o", "--out", required=True, help="a .png file")
    render.add_argument("--view", help=f"north, top ... (default: {VIEW})")
    render.add_argument("--show", help=f"also walls, patches, units (default: {SHOW})")
    render.add_argument(
        "--section", metavar="LINE", help='a vertical section along "0,2500 6000,2500 ..." [m]'
    )
    render.add_argument("--exaggeration", type=float, help="vertical, default: what reads well")
    render.add_argument("--clip", action=argparse.BooleanOptionalAction,
                        help="only what is inside the model (default: the scenario)")  # fmt: skip

    curves = add("curves", curves_command, "find the curves where two surface files meet")
    curves.add_argument("first", help="a surface: .gri .zmap .nc .ts .vtp .pol .obj ...")
    curves.add_argument("second", help="another one")
    curves.add_argument("-o", "--out", required=True, help="a .vtp, .pl or .pol file")
    curves.add_argument("--positive", choices=("up", "down"), help="where files do not say")
    curves.add_argument("--length-unit", help="length unit, where files do not say")

    add("doctor", doctor_command, "say what geosurf stands on here, and whether it can draw")
    add("warmup", warmup_command, "compile the kernels, where they are not frozen")
    _add_proofs(add)
    return parser


def _add_proofs(add: Callable[..., Any]) -> None:
    """The commands by which geosurf is put to the test."""
    stress = add("stress", stress_command, "feed the engine what breaks engines; 4 if it does")
    stress.add_argument("--cases", type=int, default=70, help="of each family (70: 30 s)")
    stress.add_argument("--seed", type=int, default=0, help="other cases for another number")
    stress.add_argument("--family", action="append", metavar="NAME", help="only this one; repeat")
    stress.add_argument("-o", "--out", help="a .json file for the table and all that failed")
    stress.add_argument("--replay", metavar="FILE", help="run one .npz case again that failed")
    stress.add_argument("--quiet", action="store_true", help="no table")


if __name__ == "__main__":
    sys.exit(main())
