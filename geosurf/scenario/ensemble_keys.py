"""The keys of ``[ensemble]`` and ``[[uncertain]]``: what `run_ensemble` varies in a scenario."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from geosurf.conventions import did_you_mean, is_number
from geosurf.errors import InputError
from geosurf.scenario import values
from geosurf.scenario.declare import key

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.model.distributions import Normal, Triangular, Uniform

# What kind of names each uncertainty takes, for the check and for its message.
KINDS = {  # what `of` names
    "depth shift": "horizons",
    "depth error": "horizons",
    "contact shift": "contacts",
    "contact level": "contacts",
    "throw": "faults",
    "throw factor": "faults",
    "fault position": "faults",
    "fault dip": "faults",
}
# Number of parameters of each.
DISTRIBUTIONS = {"normal": 2, "uniform": 2, "triangular": 3}


def _numbers(n: int) -> values.Check:
    """Return the check for so many numbers."""

    @values.check(f"{n} numbers")
    def numbers(_: values.KeyPath, value: Any) -> tuple[float, ...] | None:
        """The numbers as a tuple."""
        # Lists only: a single number would be ambiguous.
        fits = isinstance(value, list) and len(value) == n and all(map(is_number, value))
        return tuple(map(float, value)) if fits else None

    return numbers


@values.check("a whole number above 0")
def _count(_: values.KeyPath, value: Any) -> int | None:
    # type() and not isinstance(): true is an integer in Python.
    return value if type(value) is int and value > 0 else None


@values.check("a whole number, 0 or above")
def _seed(_: values.KeyPath, value: Any) -> int | None:
    return value if type(value) is int and value >= 0 else None


@dataclass(frozen=True, kw_only=True)
class EnsembleSettings:
    """``[ensemble]``: how many realisations `geosurf ensemble` builds. See
    [ensembles](guides/ensembles.md).
    """

    n: int = key("Number of realisations.", _count, default=100)
    seed: int = key("Seed of all random numbers.", _seed, default=0)
    map_cell_m: float | None = key(
        "Width of the cells of maps of probability and thickness. Left out: no maps.",
        values.above_zero,
        unit="m",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class UncertainInput:
    """One ``[[uncertain]]``: what varies in an ensemble. Give one of `normal`, `uniform` and
    `triangular`, or `sd_m` and `range_m` for a depth error. Units are metres, degrees for a dip,
    and 1 for a factor.
    """

    kind: str = key("What is uncertain.", values.one_of(*KINDS))
    of: tuple[str, ...] = key(
        "Names of the horizons, contacts or faults, which vary together. One for a contact or "
        "throw. Left empty: all horizons or faults.",
        values.names,
        default=(),
    )
    normal: tuple[float, ...] | None = key(
        "Mean and standard deviation.", _numbers(2), default=None
    )
    uniform: tuple[float, ...] | None = key("Lowest and highest value.", _numbers(2), default=None)
    triangular: tuple[float, ...] | None = key(
        "Lowest, most likely and highest value.", _numbers(3), default=None
    )
    sd_m: float | None = key(
        "With a depth error: its standard deviation.", values.above_zero, unit="m", default=None
    )
    range_m: float | None = key(
        "With a depth error: distance at which its correlation has fallen to 5 %.",
        values.above_zero,
        unit="m",
        default=None,
    )
    model: str = key(
        "With a depth error: its covariance.",
        values.one_of("gaussian", "exponential", "spherical"),
        default="gaussian",
    )
    meet_tops: bool = key(
        "With a depth error: whether it meets the well tops of `[tops]`.",
        values.switch,
        default=True,
    )


def distribution_of(entry: UncertainInput) -> Normal | Uniform | Triangular | None:
    """Return the distribution of an uncertain input; a depth error has none.

    Examples
    --------
    >>> distribution_of(UncertainInput(kind="fault dip", uniform=(-2.0, 2.0)))
    Uniform(low=-2.0, high=2.0)
    """
    from geosurf.model.distributions import Normal, Triangular, Uniform  # loaded by ensembles

    if entry.normal is not None:
        return Normal(*entry.normal)
    if entry.uniform is not None:
        return Uniform(*entry.uniform)
    return None if entry.triangular is None else Triangular(*entry.triangular)


def check_uncertain(scenario: Any, at: values.KeyPath) -> None:
    """Refuse uncertainties that contradict themselves, or name what does not exist."""
    # A sealed model has no data that could vary.
    if scenario.uncertain and scenario.model is not None:
        with at.noting():
            at.of("uncertain").refuse(
                "[[uncertain]] cannot be combined with [model]. Remove one of them."
            )
        return

    # Names as the scenario has them, by the table that they come from.
    known = {kind: [one.name for one in getattr(scenario, kind)] for kind in KINDS.values()}
    for row, entry in enumerate(scenario.uncertain):
        label = f"uncertain[number {row + 1}]"
        with at.of(label).noting():
            _check_one(scenario, entry, known[KINDS[entry.kind]], label, at.of(label))


def _check_one(
    scenario: Any, entry: UncertainInput, known: list[str], label: str, at: values.KeyPath
) -> None:
    """Refuse an uncertainty that contradicts itself, or names what does not exist."""
    # Names first: later messages use them.
    kind = KINDS[entry.kind]
    for name in entry.of:
        if name not in known:
            names = ", ".join(map(repr, dict.fromkeys(known)))
            rest = f"{kind} are {names}" if names else f"the scenario has no {kind}"
            at.inside("of").refuse(
                f"{label}: unknown name {name!r}; {rest}.{did_you_mean(name, known)}"
            )
    given = [word for word in DISTRIBUTIONS if getattr(entry, word) is not None]

    # A depth error is a random field, which has no single distribution.
    if entry.kind == "depth error":
        if given or entry.sd_m is None or entry.range_m is None:
            at.refuse(f"{label}: a depth error takes sd_m and range_m; give both, alone.")
        return
    if entry.sd_m is not None or entry.range_m is not None:
        at.refuse(f"{label}: sd_m and range_m are of a depth error; remove them.")

    # One distribution, neither none nor several.
    if len(given) != 1:
        at.refuse(f"{label}: give exactly one of {', '.join(DISTRIBUTIONS)}.")
    try:
        distribution_of(entry)
    except InputError as error:
        at.inside(given[0]).refuse(f"{label}.{given[0]}: {error}")

    # Contacts and throws differ in size: one number cannot be added to several.
    if entry.kind.startswith(("contact", "throw")) and len(entry.of) != 1:
        at.inside("of").refuse(f'{label}: a {entry.kind} has one name, as in of = ["F1"].')
    # The uncertainty changes the throw that the scenario gives.
    if entry.kind.startswith("throw") and not _has_throw(scenario, entry):
        at.refuse(f"{label}: {_no_throw(scenario, entry)}")


def _has_throw(scenario: Any, entry: UncertainInput) -> bool:
    """Whether a throw is given that the uncertainty changes."""
    # Several tables may be about one fault, each for its own horizons.
    mine = [one for one in scenario.throws if one.fault == entry.of[0]]
    return bool(mine) and (entry.kind != "throw" or all(t.throw_m is not None for t in mine))


def _no_throw(scenario: Any, entry: UncertainInput) -> str:
    """Why a throw cannot vary, and what to do."""
    fault, form = entry.of[0], "throw_m" if entry.kind == "throw" else "throw"
    # [tear] reads throws off the data: a table of [[throws]] would tear the horizons twice
    if scenario.tear is not None and not any(one.fault == fault for one in scenario.throws):
        return (
            f"horizons are torn at fault {fault!r} by [tear], so their data determine its throw. "
            'Vary the fault instead: kind = "fault position" or "fault dip". For continuous '
            f"horizons that [tear] leaves out, give {form} in [[throws]]."
        )
    return f"fault {fault!r} has no {form} in [[throws]]. Add it there."
