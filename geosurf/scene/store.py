"""Results that scenes of one family share: as many as fit into a budget, least recently used first.

Three rules bound it:

    budget     all results together stay below a number of bytes; arrays that results share count
               once. What was not requested for longest is dropped first. They are counted only when
               the whole process has had as much memory.
    family     a result that no living scene has requested is dropped after some more scenes of the
               family: in a chain of `Scene.replace` only the last few stay.
    scene      what a scene needs again and again (its surfaces, patches and units) it holds itself,
               so dropping here loses nothing of a living scene.
"""

from __future__ import annotations

import os
import re
import threading
import weakref
from collections import OrderedDict, deque
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from geosurf.conventions.memory import most_memory_so_far
from geosurf.errors import GeosurfWarning, InputError

CHOICE = "GEOSURF_MEMORY"
KEPT_SCENES = 8  # earlier scenes of the family whose results stay for later ones
_SHARE = 0.25  # of the machine's memory, where nothing is chosen
_LEAST = 1 << 30
_OVERHEAD = 1024  # of a result without arrays, roughly
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
    found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([A-Za-z]*)\s*", text, re.ASCII)
    factor = _UNIT.get(found[2].lower()) if found else None
    if found is None or factor is None or len(text) > 40:
        raise InputError(
            f"{CHOICE} is {text[:40]!r}, which is not a size. Give bytes, or a number with a unit: "
            f"{CHOICE}='2 GiB'. With 0 no results are shared."
        )
    return int(float(found[1]) * factor)


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
    found: dict[int, int] = {}
    seen: set[int] = set()
    stack = [value]

    # a stack of our own: nested results would exceed the recursion limit
    while stack:
        one = stack.pop()
        kind = _KINDS.get(type(one)) or _kind_of(type(one))
        if kind is _ARRAY:
            # views share the memory of the array that owns it
            base = one.base
            while base is not None:
                if not isinstance(base, np.ndarray):
                    break  # the owner may be no array, such as a memory map: its identity counts
                one, base = base, base.base
            found[id(one if base is None else base)] = one.nbytes
        elif kind is not _LEAF and id(one) not in seen:
            seen.add(id(one))
            stack += [part for part in _parts(one, kind) if type(part) not in _LEAF_TYPES]
    return found


class _Kind(Enum):
    """How an object holds others."""

    ARRAY, LEAF, MAPPING, SEQUENCE, OBJECT = range(5)


# results have thousands of objects, of a few dozen types
_ARRAY, _LEAF, _MAPPING, _SEQUENCE, _OBJECT = _Kind
_KINDS: dict[type, _Kind] = {}
_LEAF_TYPES: set[type] = set()
_SLOTS: dict[type, tuple[str, ...]] = {}


def _kind_of(kind: type) -> _Kind:
    """How objects of a type hold others."""
    found = _KINDS.get(kind)
    if found is None:
        found = _KINDS[kind] = _found_kind(kind)
        if found is _LEAF:
            _LEAF_TYPES.add(kind)
    return found


def _found_kind(kind: type) -> _Kind:
    if issubclass(kind, np.ndarray):
        return _ARRAY
    if issubclass(kind, _LEAVES):
        return _LEAF
    if issubclass(kind, Mapping):
        return _MAPPING
    if issubclass(kind, tuple | list | set | frozenset):
        return _SEQUENCE

    # objects of other packages are not looked into: what they hold is not ours to count
    return _OBJECT if kind.__module__.startswith(_ROOMS) else _LEAF


def _parts(one: Any, kind: _Kind) -> Iterable[Any]:
    """What an object is made of, as far as it may hold arrays."""
    if kind is _SEQUENCE:
        parts: Iterable[Any] = one
        return parts
    if kind is _MAPPING:
        return list(one.values())
    slots = _SLOTS.get(type(one))
    if slots is None:
        slots = _SLOTS[type(one)] = _slots_of(type(one))
    parts = list(getattr(one, "__dict__", {}).values())
    return [*parts, *(getattr(one, name, None) for name in slots)] if slots else parts


def _slots_of(kind: type) -> tuple[str, ...]:
    """Names in `__slots__` of a class and its bases."""
    found = []
    for part in kind.__mro__:
        slots = part.__dict__.get("__slots__", ())
        found += [slots] if isinstance(slots, str) else [*slots]
    return tuple(name for name in found if name not in ("__dict__", "__weakref__"))


@dataclass
class Entry:
    """A result, the warnings that came with it, and who requested it when; arrays once counted."""

    result: Any
    warnings: tuple[GeosurfWarning, ...]
    serial: int
    generation: int
    owners: int = 0
    buffers: dict[int, int] | None = None


class Store:
    """
    Results of a family of scenes by key, within a budget.

    Parameters
    ----------
    budget : int, optional
        Bytes; default: see `budget_of_family`.

    Attributes
    ----------
    n_dropped, bytes_dropped : int
        Results that are no longer here, and the bytes that the budget has freed.

    Examples
    --------
    >>> store, mine = Store(budget=5000), {}
    >>> for k in range(3):
    ...     store.put(k, np.zeros(300), (), mine)
    >>> [store.get(k, mine) is not None for k in range(3)]
    [False, False, True]
    >>> store.n_dropped, store.bytes_dropped, store.n_stored
    (2, 4800, 1)
    """

    def __init__(self, budget: int | None = None) -> None:
        self.budget = budget_of_family() if budget is None else budget
        self.issued: set[GeosurfWarning] = set()
        self.held: dict[int, Any] = {}  # inputs that only their identity distinguishes
        self.keys: weakref.WeakKeyDictionary[Any, Hashable] = weakref.WeakKeyDictionary()
        self.n_dropped = self.bytes_dropped = 0
        self._entries: OrderedDict[Hashable, Entry] = OrderedDict()
        self._times: dict[int, int] = {}  # in how many results an array is
        self._bytes = self._generation = self._serial = self._since_count = self._n_uncounted = 0
        self._released: deque[dict[Hashable, int]] = deque()
        self._lock = threading.RLock()

    # ---- scenes that come and go ---------------------------------------------------------

    def enter(self, owner: Any) -> dict[Hashable, int]:
        """Register a scene's memory; return where its results are noted. Drop expired results."""
        used: dict[Hashable, int] = {}
        # only noted when it goes, which may be in the middle of anything
        weakref.finalize(owner, self._released.append, used).atexit = False
        with self._lock:
            self._generation += 1

            # results of scenes that are gone lose an owner; here it is safe to change entries
            while self._released:
                for key, serial in self._released.popleft().items():
                    entry = self._entries.get(key)
                    if entry is not None and entry.serial == serial:
                        entry.owners -= 1

            # no living scene has requested it, and it is older than the last few scenes
            oldest = self._generation - KEPT_SCENES
            for key in [
                k for k, e in self._entries.items() if not e.owners and e.generation < oldest
            ]:
                self._drop(key)
        return used

    # ---- results -------------------------------------------------------------------------

    def get(self, key: Hashable, used: dict[Hashable, int]) -> Entry | None:
        """Return the result of a key, or None."""
        with self._lock:
            entry = self._entries.get(key)
            if entry is not None:
                # the order of the dictionary is that of use: the first is dropped first
                self._entries.move_to_end(key)
                self._use(key, entry, used)
            return entry

    def put(
        self,
        key: Hashable,
        result: Any,
        warnings: tuple[GeosurfWarning, ...],
        used: dict[Hashable, int],
        *,
        grows: bool = True,
    ) -> None:
        """Keep a result; drop what has not been requested for longest until all fits.

        A result that `grows` may make arrays later, so that it is counted again.
        """
        with self._lock:
            if key in self._entries:  # another thread was faster
                # the later result replaces it; both are equal
                self._take_out(self._entries.pop(key))

            # a serial number tells this result from an earlier one of the same key
            self._serial += 1
            entry = Entry(result, warnings, self._serial, self._generation)
            self._entries[key] = entry
            self._use(key, entry, used)

            # results may make arrays later; count again now and then, at a cost that averages out
            self._since_count += grows
            self._n_uncounted += 1
            if most_memory_so_far() >= self.budget:
                if self._since_count > len(self._entries) // 2 + 8:
                    self._count_again()
                self._keep_within_budget()

    def _keep_within_budget(self) -> None:
        if self._n_uncounted:
            for entry in self._entries.values():
                if entry.buffers is None:
                    self._take_in(entry)
            self._n_uncounted = 0
        # a result larger than the budget drops everything, itself at last: the scene still has it
        while self._bytes > self.budget:
            self._drop(next(iter(self._entries)))

    def _use(self, key: Hashable, entry: Entry, used: dict[Hashable, int]) -> None:
        entry.generation = self._generation

        # each scene counts once as an owner of a result, whatever it asks for
        if used.get(key) != entry.serial:
            used[key] = entry.serial
            entry.owners += 1

    def _drop(self, key: Hashable) -> None:
        entry = self._entries.pop(key)

        # arrays that other results share stay: only the difference is freed
        before = self._bytes
        self._take_out(entry)
        self.n_dropped += 1
        if entry.buffers is not None:
            self.bytes_dropped += before - self._bytes - _OVERHEAD

    # ---- bytes ---------------------------------------------------------------------------

    @property
    def n_stored(self) -> int:
        """How many results are stored."""
        return len(self._entries)

    def bytes_stored(self) -> int:
        """Count the bytes of all results again, within the budget: arrays may have been made."""
        with self._lock:
            self._count_again()
            self._keep_within_budget()
            return self._bytes

    def _count_again(self) -> None:
        self._times, self._bytes, self._since_count, self._n_uncounted = {}, 0, 0, 0
        for entry in self._entries.values():
            self._take_in(entry)

    def _take_in(self, entry: Entry) -> None:
        entry.buffers = buffers_of(entry.result)
        self._bytes += _OVERHEAD
        for one, size in entry.buffers.items():
            # an array counts when the first result brings it, and goes with the last
            self._times[one] = self._times.get(one, 0) + 1
            if self._times[one] == 1:
                self._bytes += size

    def _take_out(self, entry: Entry) -> None:
        if entry.buffers is None:
            return
        self._bytes -= _OVERHEAD
        for one, size in entry.buffers.items():
            self._times[one] -= 1
            if not self._times[one]:
                del self._times[one]
                self._bytes -= size
