"""Memory of a scene: results by what went into them, and the steps that gave them."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from typing import Any, TypeVar

from geosurf.arrangement.known_pairs import KnownPairs
from geosurf.conventions import counted
from geosurf.conventions.running import running
from geosurf.errors import GeosurfWarning
from geosurf.model import TriSurface
from geosurf.model.expected import flag_of
from geosurf.scene.ahead import Ahead
from geosurf.scene.fingerprint import fingerprint
from geosurf.scene.progress import OnStart, announced, silent
from geosurf.scene.store import Store
from geosurf.warning import collected, issue, pass_on

MANY = 10_000  # steps; from then on answers from memory are not recorded

Result = TypeVar("Result")
Stored = tuple[Any, tuple[GeosurfWarning, ...]]  # the result of a step, and its warnings


@dataclass(frozen=True)
class Step:
    """One line of `Scene.explain`."""

    stage: str
    subject: str
    outcome: str
    detail: str
    seconds: float = 0.0

    def words(self, width: int, seconds: bool) -> str:
        """Return the line, with subjects padded to one width."""
        clock = f", {self.seconds:.3f} s" if seconds and self.outcome == "ran" else ""
        subject = self.subject.ljust(width)
        return f"{self.stage:<11} {subject}  {self.outcome:<11} {self.detail}{clock}"


class Memory:
    """
    Results by key, shared by scenes that differ little, and the steps of one scene.

    Attributes
    ----------
    shares : bool
        Whether other scenes of the family get what this one computes. A scene that nobody changes
        takes from the family only, such as a realisation: its results would fill the budget.

    Examples
    --------
    >>> memory = Memory()
    >>> for _ in range(2):
    ...     two = memory.get_or_compute("add", "1 + 1", "key", lambda: 2, str)
    >>> [step.outcome for step in memory.steps]
    ['ran', 'from memory']
    """

    def __init__(
        self,
        warnings: Iterable[GeosurfWarning] = (),
        store: Store | None = None,
        on_start: OnStart = silent,
    ) -> None:
        self.steps: list[Step] = []
        self.shares = True
        self.on_start = on_start
        self.warnings: list[GeosurfWarning] = list(warnings)
        self.store = Store() if store is None else store

        # a copy brings warnings along that have been issued before
        self.store.issued.update(self.warnings)
        self._own: dict[Hashable, Stored] = {}
        self._noted: set[tuple[str, str]] = set()  # stages and subjects of all steps
        self._used = self.store.enter(self)

    def __reduce__(self) -> tuple[type[Memory], tuple[tuple[GeosurfWarning, ...]]]:
        """Copies and other processes begin with an empty memory: results are computed again there.

        Warnings go along: what they are about is still in the results that the scene itself holds.
        """
        return Memory, (tuple(self.warnings),)

    def twin(self) -> Memory:
        """Return a memory for another scene of the family, with the same results."""
        return Memory(store=self.store, on_start=self.on_start)

    def take_over(self, before: Memory, surfaces: Mapping[str, str]) -> None:
        """Hold the surfaces that another scene holds, of some inputs by name and fingerprint."""
        for key, stored in before._own.items():
            if isinstance(key, tuple) and key[0] == "surface" and surfaces.get(key[1]) == key[3]:
                self._own[key] = stored

    def warn(self, *warnings: GeosurfWarning, issued: bool = False) -> None:
        """Keep warnings of this scene, and issue those that no scene of the family has issued.

        Parameters
        ----------
        *warnings : GeosurfWarning
        issued : bool
            Whether whoever found them has issued them.
        """
        # each scene lists all of its warnings, but the family issues each once
        for warning in warnings:
            pass_on(warning)  # a step within a step: both carry it
            if warning not in self.warnings:
                self.warnings.append(warning)
        for warning in warnings:
            if warning not in self.store.issued:
                self.store.issued.add(warning)
                if not issued:
                    issue(warning)

    @contextmanager
    def collecting(self) -> Iterator[None]:
        """Keep what is warned of inside the ``with`` block as warnings of this scene."""
        found: list[GeosurfWarning] = []
        try:
            with collected() as found:
                yield
        finally:
            self.warn(*found)

    def key_of(self, surface: TriSurface) -> Hashable:
        """Return the key of a surface: that of the step that made it, else its fingerprint."""
        # weak keys: a surface that nobody holds takes its key along
        keys = self.store.keys
        if surface not in keys:
            keys[surface] = fingerprint(surface)
        return keys[surface]

    def made_of(self, surface: TriSurface, key: Hashable) -> None:
        """Identify a surface by the key of the step that made it."""
        # a key of inputs and settings stands for the content and saves a hash over all arrays
        self.store.keys.setdefault(surface, key)

    def known_pairs(self, surfaces: Sequence[TriSurface]) -> KnownPairs:
        """Return what scenes of the family know of pairs of these surfaces."""

        def get(key: Hashable) -> Any:
            stored = self._shared(key)
            return None if stored is None else stored[0]

        def put(key: Hashable, one: Any) -> None:
            if self.shares:
                self.store.put(key, one, (), self._used, grows=False)

        def key_of(surface: TriSurface) -> Hashable:
            # walls are made anew by each scene, and have a few numbers
            if surface.role != "wall":
                return self.key_of(surface)
            return surface.name, surface.vertices.tobytes(), surface.triangles.tobytes()

        return KnownPairs(get, put, [key_of(surface) for surface in surfaces])

    def stored_for(self, owner: object, key: Hashable, run: Callable[[], Result]) -> Result:
        """Return a part of a step, from memory if it was made of the same object; no step."""
        known = self._own.get(key) or self._shared(key)
        if known is not None and known[0][0] is owner:
            found: Result = known[0][1]
            return found
        result = run()
        self._put(key, ((owner, result), ()))
        return result

    def hold(self, value: Any) -> str:
        """Return the fingerprint of an input, and hold one that only its identity distinguishes."""
        # an identity means nothing once its object is gone: hold it
        strangers: list[Any] = []
        found = fingerprint(value, strangers)
        self.store.held.update((id(one), one) for one in strangers)
        return found

    def knows(self, key: Hashable) -> bool:
        """Whether the result of a step is in memory."""
        return (self._own.get(key) or self._shared(key)) is not None

    def is_quiet(self, key: Hashable) -> bool:
        """Whether the result of a step is in memory, and had no warning."""
        known = self._own.get(key) or self._shared(key)
        return known is not None and not known[1]

    def get_or_compute(
        self,
        stage: str,
        subject: str,
        key: Hashable,
        run: Callable[[], Result],
        describe: Callable[[Result], str],
        *,
        again: bool = True,
        reports: bool = True,
    ) -> Result:
        """Return the result of a step: from memory if it is there.

        Without `again` it is a step on the way, such as a surface: the scene itself holds its
        result, since it asks often, and explains it once. Without `reports` the caller calls
        `on_start`, since it knows how many such steps there are.
        """
        result: Result

        # the scene's own results first: they are never dropped
        # own results by key, then those of the family, which the budget may have dropped
        known = self._own.get(key) or self._shared(key)
        if known is not None:
            result, warnings = known
            self.warn(*warnings)

            # a line in the log when a result was asked for, not each time that a stage looks it up
            if again or (stage, subject) not in self._noted:
                self.note(stage, subject, "from memory", describe(result))
        else:
            if reports:
                self.on_start(stage, subject, 1, 1)
            result, warnings = self._run(stage, subject, key, run, describe)

        # held for the scene's life: stages ask for surfaces hundreds of times
        if not again:
            self._own[key] = result, warnings
        return result

    def _put(self, key: Hashable, stored: Stored) -> None:
        """Keep a result: for the family, or for this scene alone."""
        if self.shares:
            self.store.put(key, *stored, self._used)
        else:
            self._own[key] = stored

    def _shared(self, key: Hashable) -> Stored | None:
        entry = self.store.get(key, self._used)
        return None if entry is None else (entry.result, entry.warnings)

    def _run(
        self,
        stage: str,
        subject: str,
        key: Hashable,
        run: Callable[[], Result],
        describe: Callable[[Result], str],
    ) -> tuple[Result, tuple[GeosurfWarning, ...]]:
        """Run a step, keep its result with its warnings, and issue these."""
        # warnings are collected, so that they come back with the result from memory
        start = time.perf_counter()
        found: list[GeosurfWarning] = []
        try:
            # who is called at each start has a display of their own
            shown = running(f"{stage} {subject}") if self.on_start is announced else nullcontext()
            with shown, collected() as found:
                result = run()
            warnings = tuple(dict.fromkeys(found))
            self._put(key, (result, warnings))
            seconds = run.seconds if isinstance(run, Ahead) else time.perf_counter() - start
            self.note(stage, subject, "ran", describe(result), seconds)

        # a step that fails has warnings, too; they may explain why
        finally:
            self.warn(*found)
        return result, warnings

    def summary(self) -> Step:
        """Shared results in memory, and those that were dropped, as a line of `explain`."""
        store = self.store
        stored = f"{counted(store.n_stored, 'result')}, {in_bytes(store.bytes_stored())}"
        dropped = counted(store.n_dropped, "result")
        if store.bytes_dropped:
            dropped += f" ({in_bytes(store.bytes_dropped)} by this limit)"
        detail = f"{stored} of at most {in_bytes(store.budget)}; dropped: {dropped}"
        return Step("memory", "of the family", "stored", detail)

    def explain(self, seconds: bool) -> str:
        """Return all steps, one a line; see `Scene.explain`."""
        steps = list(self.steps)
        if flag_of(seconds, "seconds") and steps:
            steps.append(self.summary())
        width = max((len(step.subject) for step in steps), default=0)
        return "\n".join(step.words(width, seconds) for step in steps)

    def note(
        self, stage: str, subject: str, outcome: str, detail: str, seconds: float = 0.0
    ) -> None:
        """Record one step; after MANY steps no more answers from memory."""
        # loops over pairs of surfaces ask often; lines beyond MANY tell nothing new
        if outcome == "from memory" and len(self.steps) >= MANY:
            return
        self.steps.append(Step(stage, subject, outcome, detail, seconds))
        self._noted.add((stage, subject))


def in_bytes(n: int) -> str:
    """Return a number of bytes as people read it.

    Examples
    --------
    >>> in_bytes(512), in_bytes(2_300_000), in_bytes(1 << 34)
    ('512 B', '2.3 MB', '17 GB')
    """
    for unit, size in (("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if n >= size:
            return f"{n / size:.2g} {unit}" if n < 10 * size else f"{n / size:.0f} {unit}"
    return f"{n} B"
