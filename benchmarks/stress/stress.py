"""Many cases, a table, and a file for each one that fails."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from types import TracebackType

from benchmarks.stress import judge
from benchmarks.stress.case import Case, shuffled
from benchmarks.stress.families import FAMILIES, make_case
from benchmarks.stress.reproducer import load_case, save_case
from geosurf.arrangement import intersect_triangles
from geosurf.errors import InputError, RoundingError
from geosurf.intersect import intersect_surfaces
from geosurf.model import Patches
from geosurf.rebuild import rebuild_surfaces

CASES = 70
MOST_PAIRS = 40
HEAD = (
    f"{'family':<16}{'cases':>8}{'wrong':>7}{'refused':>9}{'error [ulp]':>13}{'error [m]':>11}"
    f"{'repairs':>9}{'move [m]':>10}{'seconds':>9}"
)


@dataclass
class Outcome:
    """What one case came to.

    Attributes
    ----------
    wrong : list of str
        Violations; empty for a right answer.
    refused : str
        The message of a `RoundingError`, or empty.
    error, error_ulp : float
        Largest error of a constructed coordinate that the judge knows exactly [m], and in ulp.
    move : float
        How far inputs were moved to repair rounding [m].
    repaired : bool
    """

    wrong: list[str] = field(default_factory=list)
    refused: str = ""
    error: float = 0.0
    error_ulp: float = 0.0
    move: float = 0.0
    repaired: bool = False

    def take(self, verdict: judge.Verdict) -> None:
        """Take a verdict in."""
        self.wrong += verdict.wrong
        self.error = max(self.error, verdict.error)
        self.error_ulp = max(self.error_ulp, verdict.error_ulp)


@dataclass
class FamilyResult:
    """One row of the table; lengths in metres, times in seconds."""

    family: str
    cases: int = 0
    wrong: int = 0
    refused: int = 0
    error_ulp: float = 0.0
    error_m: float = 0.0
    repairs: int = 0
    largest_move_m: float = 0.0
    seconds: float = 0.0
    failures: list[dict] = field(default_factory=list)
    refusals: list[dict] = field(default_factory=list)

    def line(self) -> str:
        """The row as text, below `HEAD`."""
        return (
            f"{self.family:<16}{self.cases:>8}{self.wrong:>7}{self.refused:>9}"
            f"{self.error_ulp:>13.3f}{self.error_m:>11.1e}{self.repairs:>9}"
            f"{self.largest_move_m:>10.1e}{self.seconds:>9.1f}"
        )

    def add(self, number: int, outcome: Outcome) -> None:
        """Count one case."""
        self.cases += 1
        self.wrong += bool(outcome.wrong)
        self.refused += bool(outcome.refused)
        self.error_ulp = max(self.error_ulp, outcome.error_ulp)
        self.error_m = max(self.error_m, outcome.error)
        self.repairs += outcome.repaired
        self.largest_move_m = max(self.largest_move_m, outcome.move)
        if outcome.wrong:
            self.failures.append({"number": number, "wrong": outcome.wrong})
        if outcome.refused:
            self.refusals.append({"number": number, "refused": outcome.refused})


class _Attempt:
    """Notes what the engine raises: a refusal for rounding, anything else is wrong."""

    def __init__(self, outcome: Outcome, step: str) -> None:
        self._outcome = outcome
        self._step = step

    def __enter__(self) -> None:
        """Begin."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> bool:
        """Keep going after anything but an interruption."""
        if kind is None or not issubclass(kind, Exception):
            return False

        # a refusal is no wrong answer: the engine says that rounding leaves no valid mesh. Any
        # other error is one
        if issubclass(kind, RoundingError):
            self._outcome.refused = str(error)
        else:
            self._outcome.wrong.append(f"{self._step}: {kind.__name__}: {error}")
        return True


def run_case(case: Case) -> Outcome:
    """
    Run the engine on one case and judge what comes back.

    Parameters
    ----------
    case : Case

    Returns
    -------
    Outcome

    Examples
    --------
    >>> run_case(make_case("catalogue", 12)).wrong
    []
    """
    outcome = Outcome()
    itself = case.self_intersections
    contact = None
    # Two single triangles: the direct question as well.
    with _Attempt(outcome, "intersect_triangles"):
        if len(case.surfaces) == 2 and all(s.n_triangle == 1 for s in case.surfaces):
            P, Q = (s.vertices[s.triangles[0]] for s in case.surfaces)
            contact = intersect_triangles(P, Q)
            outcome.take(judge.judge_contact(P, Q, contact))

    met, complete, of = None, False, None

    # each step by itself: one that fails does not hide what the next one does
    with _Attempt(outcome, "intersect_surfaces"):
        curves = intersect_surfaces(case.surfaces, self_intersections=itself)
        met, complete = judge.meetings(case.surfaces, curves.origin, MOST_PAIRS, itself)
        of = curves.origin
        outcome.take(judge.judge_curves(case.surfaces, curves, met, complete))
        outcome.take(judge.judge_known(case.known, contact, curves))

    with _Attempt(outcome, "rebuild_surfaces"):
        patches = rebuild_surfaces(case.surfaces, self_intersections=itself)
        outcome.repaired = patches.report["moved_vertices"] > 0
        outcome.move = patches.report["largest_move"]
        # Moved vertices have other meetings than the input.
        if met is None or outcome.repaired or (patches.origin != of).any():
            met, _ = judge.meetings(patches.sources, patches.origin, MOST_PAIRS, itself)
        outcome.take(judge.judge_patches(case.surfaces, patches, met, itself))

        # where vertices were moved, another order may move others: only meshes without repairs are
        # compared
        if not outcome.repaired:
            outcome.take(_judge_shuffled(case, patches))
    return outcome


def _judge_shuffled(case: Case, patches: Patches) -> judge.Verdict:
    """Rebuild the same in another order, and compare."""
    other = Outcome()
    with _Attempt(other, "in another order"):
        again = rebuild_surfaces(
            shuffled(case).surfaces, self_intersections=case.self_intersections
        )
        return judge.judge_order(patches, again)
    return judge.Verdict(other.wrong or [f"refused in another order: {other.refused}"])


def run_stress(
    cases: int = CASES,
    seed: int = 0,
    families: Sequence[str] | None = None,
    *,
    keep: str | os.PathLike[str] | None = None,
    progress: Callable[[str], object] | None = None,
) -> list[FamilyResult]:
    """
    Run many cases of all families.

    Parameters
    ----------
    cases : int
        For each family. 70 take about 30 s in all, 100 000 half a day.
    seed : int
        Other cases for another one; the same ones for the same.
    families : sequence of str, optional
        Default: all of `FAMILIES`.
    keep : path-like, optional
        Folder for a file of each case that fails.
    progress : callable, optional
        Called with each line of the table.

    Returns
    -------
    list of FamilyResult

    Raises
    ------
    InputError
        For an unknown family, or fewer cases than one.

    Examples
    --------
    >>> [row] = run_stress(2, families=["triple lines"])
    >>> row.cases, row.wrong
    (2, 0)
    """
    if cases < 1:
        raise InputError(f"cases is {cases}. Give at least 1.")
    names = list(dict.fromkeys(families or FAMILIES))
    for name in names:
        make_case(name, 0, seed)  # an unknown one is named before anything runs

    report = progress or (lambda line: None)
    run_case(make_case("overlaps", 1))  # kernels are compiled before clocks start
    report(HEAD)
    results = []

    for name in names:
        row = FamilyResult(name)

        # clocks run for each family: the table shows which cases are slow
        start = time.perf_counter()
        for number in range(cases):
            case = make_case(name, number, seed)
            outcome = run_case(case)
            row.add(number, outcome)
            if outcome.wrong and keep is not None:
                row.failures[-1]["file"] = str(save_case(case, keep))
        row.seconds = time.perf_counter() - start
        report(row.line())
        results.append(row)
    return results


def replay(path: str | os.PathLike[str]) -> tuple[Case, Outcome]:
    """Run a case from a file again.

    Parameters
    ----------
    path : path-like
        As written by `run_stress` for a case that failed.

    Returns
    -------
    case : Case
    outcome : Outcome

    Raises
    ------
    InputError
        If it is not such a file.
    """
    case = load_case(path)
    return case, run_case(case)
