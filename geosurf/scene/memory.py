"""Memory of a scene: results by what went into them, and the steps that gave them."""

from __future__ import annotations

import hashlib
import os
import re
import sys
import threading
import time
import weakref
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from geosurf.arrangement.candidates import KnownPairs
from geosurf.conventions import counted
from geosurf.conventions.crs import crs_of
from geosurf.conventions.machine import most_memory_so_far
from geosurf.conventions.running import count_of, running
from geosurf.errors import GeosurfWarning, InputError, collected, issue, pass_on
from geosurf.model import FaultSticks, FluidContact, Sheet, TriSurface
from geosurf.model.expected import flag_of
from geosurf.model.surfaces import Sector

# ---- fingerprint ----------------------------------------
# Fingerprints: hashes of what the inputs of a scene hold.


_PART = 1 << 24  # bytes of a file that are read at once
Unknown = Callable[[Any], str]


def by_identity(value: Any) -> str:
    """What stands for an object of which nothing is known, as long as somebody holds it."""
    return f"{id(value)}"


def fingerprint(value: Any, unknown: Unknown = by_identity) -> str:
    """
    Return a hash of what an input of a scene holds.

    Parameters
    ----------
    value : path, TriSurface, Sheet, FaultSticks, xarray object, arrays, or anything else
        Files count by path and content.
    unknown : callable
        Returns what stands for an object of which nothing is known.

    Returns
    -------
    str

    Examples
    --------
    >>> one, two = (TriSurface("F1", "fault", np.eye(3), [[0, 1, 2]]) for _ in range(2))
    >>> fingerprint(one) == fingerprint(two) != fingerprint(one.renamed("F2"))
    True
    >>> fingerprint({"W-1": {"z": [1.0, "a"]}}) == fingerprint({"W-1": {"z": [2.0, "a"]}})
    False
    """
    digest = hashlib.sha256()
    _add(digest, value, unknown)
    return digest.hexdigest()


def known_fingerprint(value: Any) -> str | None:
    """Return the fingerprint of what an input holds; None if only its identity is known."""
    strangers: list[Any] = []

    def note(stranger: Any) -> str:
        strangers.append(stranger)
        return by_identity(stranger)

    content = fingerprint(value, note)
    return None if strangers else content


def _add(digest: Any, value: Any, unknown: Unknown) -> None:
    """Add one input to a hash, with the lengths and kinds that separate its parts."""
    if isinstance(value, Sheet):
        # a sheet is its torn mesh; reports and cut-offs follow from it
        if value.mesh is not None:
            _add(digest, value.surface, unknown)
            return
        # the lattice, and the triangles at its faults: the mesh follows from them
        digest.update(f"{value.name} {value.crs}".encode())
        _add(digest, TriSurface(value.name, "horizon", lattice=value.lattice), unknown)
        _add(digest, (value.divided, value.copies, value.ghosts, value.outer), unknown)
        for sector in value.sectors:
            _add_sector(digest, sector, unknown)
        for key, array in sorted((value.walls or {}).items()):
            digest.update(f"wall of {key}".encode())
            _add(digest, array, unknown)
        if value.extrapolated is not None:
            _add(digest, value.extrapolated, unknown)
    elif isinstance(value, str | Path):
        # by path and content: a file that changes is another input
        path = Path(value)
        name = str(path.resolve()).encode()
        digest.update(f"{len(name)} ".encode() + name)
        _add_file(digest, path)
    elif isinstance(value, TriSurface):
        digest.update(f"{value.name} {value.role} {value.crs}".encode())
        if value.lattice is None:
            _add(digest, (value.vertices, value.triangles), unknown)
        else:  # as a lattice: its triangles need not be made
            grid = value.lattice
            digest.update(f"{grid.rising} {grid.reverse}".encode())
            _add(digest, (grid.easting, grid.northing, grid.elevation), unknown)
        for sector in value.sectors:
            _add_sector(digest, sector, unknown)
        for key, array in sorted(value.vertex_data.items()):
            digest.update(key.encode())
            _add(digest, array, unknown)
    elif isinstance(value, FluidContact):
        digest.update(f"{value.zones} {value.block!r} {value.name!r}".encode())
        _add(digest, value.at, unknown)
    elif isinstance(value, FaultSticks):
        digest.update(f"{value.crs}".encode())
        _add(digest, tuple(value.sticks), unknown)
    elif hasattr(value, "to_dict") and hasattr(value, "coords"):
        # attributes count, since they may hold unit, direction and reference system
        # of coordinates the arrays alone: labels cost more than what they label
        coords = getattr(value.coords, "variables", value.coords)
        arrays = {**getattr(value, "data_vars", {"": value}), **coords}
        _add_attrs(digest, value.attrs)
        digest.update(f"{crs_of(value)}".encode())
        for key, array in arrays.items():
            digest.update(f"{key} {array.dims}".encode())
            _add_attrs(digest, array.attrs)
            _add(digest, array.values, unknown)
    elif isinstance(value, np.ndarray) and not value.dtype.hasobject:
        digest.update(f"{value.dtype} {value.shape}".encode())

        # after kind and shape: equal bytes may mean different numbers
        digest.update(np.ascontiguousarray(value))
        # without the module there are none, and loading it takes a while
        if "numpy.ma" in sys.modules and isinstance(value, np.ma.MaskedArray):
            _add(digest, np.ma.getmaskarray(value), unknown)
    elif isinstance(value, tuple | list):
        # the length first, so that (a, b), c and a, (b, c) differ
        digest.update(f"{type(value).__name__} {len(value)}".encode())
        digest.update(getattr(value, "crs", "").encode())  # of a `PlainMesh`
        for part in value:
            _add(digest, part, unknown)
    elif isinstance(value, Mapping):
        _add_words(digest, list(value.items()), unknown)
    elif hasattr(value, "columns") and hasattr(value, "index"):  # a table of pandas
        for part in (value.columns, value.index, value):
            _add_words(digest, part.to_numpy(), unknown)
    elif isinstance(value, int | float | np.number):
        digest.update(f"{value!r} ".encode())
    # of other classes the code is not known: in a notebook it may change
    elif is_dataclass(value) and type(value).__module__.startswith("geosurf."):
        digest.update(f"{type(value).__name__} {getattr(value, 'crs', '')}".encode())
        _add_words(digest, [getattr(value, field.name) for field in fields(value)], unknown)
    else:
        digest.update(f"{unknown(value)} ".encode())


def _add_words(digest: Any, value: Any, unknown: Unknown) -> None:
    """Add a part of a table: words and numbers by what they are, here no words are paths."""
    if isinstance(value, np.ndarray) and value.dtype.hasobject:
        value = value.tolist()
    if isinstance(value, list | tuple):
        digest.update(f"{len(value)} ".encode())
        for part in value:
            _add_words(digest, part, unknown)
    elif value is None or isinstance(value, str):
        digest.update(f"{value!r} ".encode())
    else:
        _add(digest, value, unknown)


def _add_sector(digest: Any, sector: Sector, unknown: Unknown) -> None:
    digest.update(f"{sector.faults} {sector.front} {sector.rising}".encode())
    _add(digest, (sector.corner, sector.step, sector.elevation), unknown)


def _add_file(digest: Any, path: Path) -> None:
    """Add the content of a file, a part at a time; of a store, names, sizes and times of files."""
    if path.is_dir():
        for folder, _, names in sorted(os.walk(path)):
            for name in sorted(names):
                state = (Path(folder) / name).stat()
                digest.update(f"{folder} {name} {state.st_size} {state.st_mtime_ns} ".encode())
    elif path.is_file():
        with path.open("rb") as file:
            while part := file.read(_PART):
                digest.update(part)
    else:
        digest.update(b"missing")


def _add_attrs(digest: Any, attrs: Any) -> None:
    digest.update(repr(sorted((str(k), str(v)) for k, v in attrs.items())).encode())


MANY = 10_000  # steps; from then on answers from memory are not recorded

Result = TypeVar("Result")
Stored = tuple[Any, tuple[GeosurfWarning, ...]]  # the result of a step, and its warnings


# stage, subject, number of this step, and of all steps of the stage that are known so far
OnStart = Callable[[str, str, int, int], object]


def silent(stage: str, subject: str, number: int, count: int) -> None:
    """Report nothing."""


def announced(stage: str, subject: str, number: int, count: int) -> None:
    """Count for the line that shows what is running, where somebody watches."""
    count_of(f"{stage} {subject}", number, count)


def on_start_of(value: OnStart | None) -> OnStart:
    """
    Return what a scene calls before each step.

    Raises
    ------
    InputError
        If it cannot be called.

    Examples
    --------
    >>> on_start_of(None) is announced
    True
    """
    if value is None:
        return announced
    if not callable(value):
        raise InputError(
            f"on_start is {value!r}; give a function of stage, subject, number and count, such as "
            "print."
        )
    return value


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
        self.shows = on_start is announced  # others have a display of their own
        self.warnings: list[GeosurfWarning] = list(warnings)
        self.store = Store() if store is None else store

        # a copy brings warnings along that have been issued before
        self.store.issued.update(self.warnings)
        self._own: dict[Hashable, Stored] = {}
        self._has_asked = False
        self._noted: set[tuple[str, str]] = set()  # stages and subjects of all steps

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
        warnings: list[GeosurfWarning] = []
        try:
            with collected() as warnings:
                yield
        finally:
            self.warn(*warnings)

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
                self.store.put(key, one, (), grows=False)

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
        return fingerprint(value, self._held)

    def _held(self, value: Any) -> str:
        """The identity of an object; it means nothing once the object is gone."""
        self.store.held[id(value)] = value
        return by_identity(value)

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
            self.store.put(key, *stored)
        else:
            self._own[key] = stored

    def _shared(self, key: Hashable) -> Stored | None:
        if not self._has_asked:
            self._has_asked = True
            self.store.scenes += 1
        entry = self.store.get(key)
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
        issued: list[GeosurfWarning] = []
        try:
            shown = running(f"{stage} {subject}") if self.shows else nullcontext()
            with shown, collected() as issued:
                result = run()
            warnings = tuple(dict.fromkeys(issued))
            self._put(key, (result, warnings))
            seconds = time.perf_counter() - start
            self.note(stage, subject, "ran", describe(result), seconds)

        # a step that fails has warnings, too; they may explain why
        finally:
            self.warn(*issued)
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


CHOICE = "GEOSURF_MEMORY"
_SHARE = 0.25  # of the machine's memory, where nothing is chosen
_LEAST = 1 << 30
_OVERHEAD = 1024  # of a result without arrays, roughly
RECENT = 16  # scenes of a family: what none of the last ones has used goes
_UNIT = {"": 1, "b": 1, "kb": 10**3, "mb": 10**6, "gb": 10**9, "tb": 10**12,
         "kib": 1 << 10, "mib": 1 << 20, "gib": 1 << 30, "tib": 1 << 40}  # fmt: skip
_LEAVES = (str, bytes, int, float, complex, bool, type(None), type, np.generic, np.dtype)
_ROOMS = ("geosurf", "xarray")  # whose objects are looked into


def budget_of_family() -> int:
    """Return how many bytes shared results may take: GEOSURF_MEMORY, or a quarter of the memory.

    Raises
    ------
    InputError
        If GEOSURF_MEMORY is not a size such as ``2 GiB``.
    """
    text = os.environ.get(CHOICE)
    if text is None:
        return max(int(_SHARE * _memory_of_machine()), _LEAST)

    # ASCII digits only: \d takes those of other scripts, too
    size = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([A-Za-z]*)\s*", text, re.ASCII)
    factor = _UNIT.get(size[2].lower()) if size else None
    if size is None or factor is None or len(text) > 40:
        raise InputError(
            f"{CHOICE} is {text[:40]!r}, which is not a size. Give bytes, or a number with a unit: "
            f"{CHOICE}='2 GiB'. With 0 no results are shared."
        )
    return int(float(size[1]) * factor)


def _memory_of_machine() -> int:
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):  # not known on this system
        return 0


def buffers_of(value: Any) -> dict[int, int]:
    """
    Return the memory that a result holds: identity and bytes of each array that owns its data.

    Examples
    --------
    >>> one = np.zeros(10)
    >>> sorted(buffers_of({"a": one, "b": [one[2:], one.reshape(2, 5)]}).values())
    [80]
    """
    sizes: dict[int, int] = {}
    seen: set[int] = set()
    stack = [value]

    # a stack of our own: nested results would exceed the recursion limit
    while stack:
        held = stack.pop()
        if isinstance(held, np.ndarray):
            # views share the memory of the array that owns it
            base = held.base
            while base is not None:
                if not isinstance(base, np.ndarray):
                    break  # the owner may be no array, such as a memory map: its identity counts
                held, base = base, base.base
            sizes[id(held if base is None else base)] = held.nbytes
        elif id(held) not in seen:
            seen.add(id(held))
            stack += _parts(held)
    return sizes


def _parts(holder: Any) -> Iterable[Any]:
    """What an object is made of, as far as it may hold arrays."""
    if isinstance(holder, Mapping):
        return list(holder.values())
    if isinstance(holder, tuple | list | set | frozenset):
        return holder
    kind = type(holder)

    # objects of other packages are not looked into: what they hold is not ours to count
    if issubclass(kind, _LEAVES) or not kind.__module__.startswith(_ROOMS):
        return ()
    slots = [part.__dict__.get("__slots__", ()) for part in kind.__mro__]
    names = [name for of in slots for name in ([of] if isinstance(of, str) else of)]
    held = getattr(holder, "__dict__", {})
    return [*held.values(), *(getattr(holder, n, None) for n in names if not n.startswith("__"))]


@dataclass
class Entry:
    """A result, the warnings that came with it, and its arrays once they are counted."""

    result: Any
    warnings: tuple[GeosurfWarning, ...]
    buffers: dict[int, int] | None = None
    scene: int = 0  # number of the one that used it last


class Store:
    """
    Results of a family of scenes by key, within a budget, that one of the last scenes has used.

    Parameters
    ----------
    budget : int, optional
        Bytes; default: see `budget_of_family`.

    Attributes
    ----------
    scenes : int
        How many have asked for something.
    n_dropped, bytes_dropped : int
        Results that are no longer here, and the bytes that the budget has freed.

    Examples
    --------
    >>> store = Store(budget=5000)
    >>> for k in range(3):
    ...     store.put(k, np.zeros(300), ())
    >>> [store.get(k) is not None for k in range(3)]
    [False, False, True]
    >>> store.n_dropped, store.bytes_dropped, store.n_stored
    (2, 4800, 1)
    """

    def __init__(self, budget: int | None = None) -> None:
        self.budget = budget_of_family() if budget is None else budget
        self.disk: Any = None  # a `ResultCache` in which torn horizons are looked for
        self.issued: set[GeosurfWarning] = set()
        self.held: dict[int, Any] = {}  # inputs that only their identity distinguishes
        self.keys: weakref.WeakKeyDictionary[Any, Hashable] = weakref.WeakKeyDictionary()
        self.n_dropped = self.bytes_dropped = self.scenes = 0
        self._entries: OrderedDict[Hashable, Entry] = OrderedDict()
        self._since_count = 0
        self._lock = threading.RLock()

    # ---- results -------------------------------------------------------------------------

    def get(self, key: Hashable) -> Entry | None:
        """Return the result of a key, or None."""
        with self._lock:
            entry = self._entries.get(key)
            if entry is not None:
                # the order of the dictionary is that of use: the first is dropped first
                self._entries.move_to_end(key)
                entry.scene = self.scenes
            return entry

    def put(
        self,
        key: Hashable,
        result: Any,
        warnings: tuple[GeosurfWarning, ...],
        *,
        grows: bool = True,
    ) -> None:
        """Keep a result; drop what has not been requested for longest until all fits.

        A result that `grows` may make arrays later, so that it is counted again.
        """
        with self._lock:
            # another thread was faster: the later result replaces its, both are equal
            self._entries.pop(key, None)
            self._entries[key] = Entry(result, warnings, scene=self.scenes)
            while next(iter(self._entries.values())).scene < self.scenes - RECENT:
                self._entries.popitem(last=False)
                self.n_dropped += 1

            # results may make arrays later; count again now and then, at a cost that averages out;
            # after small ones, pairs of surfaces, a larger one asks for the memory soon
            self._since_count += grows
            if grows and most_memory_so_far() >= self.budget:
                self._keep_within_budget(self._since_count > len(self._entries) // 2 + 8)

    def _keep_within_budget(self, anew: bool) -> int:
        """Drop what has not been requested for longest; the bytes that stay. Counts all if anew."""
        if anew:
            self._since_count = 0
        # arrays that results share count once, with the one that was requested last
        sizes: dict[int, int] = {}
        total, n_kept = 0, 0
        for entry in reversed(self._entries.values()):
            if anew or entry.buffers is None:
                entry.buffers = buffers_of(entry.result)
            more = {buffer: n for buffer, n in entry.buffers.items() if buffer not in sizes}
            if total + sum(more.values()) + _OVERHEAD > self.budget:
                break
            sizes |= more
            total, n_kept = total + sum(more.values()) + _OVERHEAD, n_kept + 1

        # a result larger than the budget drops everything, itself at last: the scene still has it
        freed: dict[int, int] = {}
        for key in list(self._entries)[: len(self._entries) - n_kept]:
            freed |= self._entries.pop(key).buffers or {}
            self.n_dropped += 1
        self.bytes_dropped += sum(n for buffer, n in freed.items() if buffer not in sizes)
        return total

    # ---- bytes ---------------------------------------------------------------------------

    @property
    def n_stored(self) -> int:
        """How many results are stored."""
        return len(self._entries)

    def bytes_stored(self) -> int:
        """Count the bytes of all results again, within the budget: arrays may have been made."""
        with self._lock:
            return self._keep_within_budget(True)
