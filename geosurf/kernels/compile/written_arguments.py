"""Which arguments does a kernel write? Determined from its source, without declarations.

A kernel writes an argument if it assigns to an element or a slice of it, under any name, or passes
it to a kernel that does, also as a field of a named tuple. Over-estimates are harmless unless a
read-only array is passed; under-estimates are found by `plain_runner`, which passes all other
arrays read-only.
"""

from __future__ import annotations

import ast
import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from geosurf.kernels.compile.file_cache import Store
from geosurf.kernels.compile.sources import kernel_files

Name = tuple[str, str]  # file, function
Place = tuple[int, str]  # an argument, and a field of it where that is a named tuple, else ""
_STEPS = (ast.Assign, ast.For, ast.AugAssign, ast.AnnAssign, ast.Return, ast.Call)
_IN_PLACE = {"fill", "sort", "partition", "put", "itemset"}
_SAME_MEMORY = {"asarray", "ascontiguousarray", "ravel", "reshape", "transpose", "view"}


@cache
def cached_arguments(folder: str) -> Mapping[str, tuple[int, ...]]:
    """Return `written_arguments`, cached by the content of all files of the folder.

    The analysis takes half a second of processor time, as much as everything else in a process that
    cuts two small surfaces. Without a cache it is repeated in each process.
    """
    store, name = Store(), _name_for(folder)
    cached = store.load(name)
    if cached is not None:
        # JSON has lists only.
        return {key: tuple(places) for key, places in json.loads(cached).items()}
    found = written_arguments(folder)
    store.save(name, json.dumps(found).encode())
    return found


def _name_for(folder: str) -> str:
    """Name of the file for what a folder holds."""
    digest = hashlib.sha256()
    for path in kernel_files(Path(folder)):
        # Names and lengths keep the contents of neighbouring files apart.
        data = path.read_bytes()
        digest.update(f"{path.name} {len(data)}\n".encode() + data)
    return f"geosurf-writes-{digest.hexdigest()[:40]}.json"


@cache
def written_arguments(folder: str) -> Mapping[str, tuple[int, ...]]:
    """Places of the arguments that each function writes, by ``file.function``.

    Parameters
    ----------
    folder : str
        Folder of kernel files and of rooms with such. What they import is looked up there.

    Returns
    -------
    Mapping of str to tuple of int

    Examples
    --------
    >>> found = written_arguments(str(Path(__file__).parents[1]))
    >>> found["predicates.orient3d_rows"]  # m counts, w is the workspace, out the result
    (2, 3, 4)
    """
    # First every function of every file, then who calls whom.
    functions: dict[Name, _Function] = {}
    bundles: dict[str, list[str]] = {}
    for path in kernel_files(Path(folder)):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names = dict(_names(path.stem, tree))
        for node in tree.body:
            if isinstance(node, ast.FunctionDef):
                functions[path.stem, node.name] = _Function(node, names, bundles)
            elif isinstance(node, ast.ClassDef):
                bundles[node.name] = _fields(node)
    moved = True
    while moved:  # until no function learns anything from those that it calls
        moved = any([function.learn(functions) for function in functions.values()])
    return {
        f"{file}.{name}": tuple(sorted({place for place, _ in function.writes}))
        for (file, name), function in functions.items()
    }


def _fields(node: ast.ClassDef) -> list[str]:
    """Names of the fields of a named tuple, in order; none for other classes."""
    # Only named tuples bundle arrays in kernels.
    if not any(isinstance(base, ast.Name) and base.id == "NamedTuple" for base in node.bases):
        return []
    return [
        part.target.id
        for part in node.body
        if isinstance(part, ast.AnnAssign) and isinstance(part.target, ast.Name)
    ]


def _names(file: str, tree: ast.Module) -> Iterator[tuple[str, Name]]:
    """What a name means in a file: a function of its own or of another kernel file."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, (file, node.name)
        # Kernels import functions by name; the last part of a module is its file.
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                yield alias.asname or alias.name, (node.module.rpartition(".")[2], alias.name)


@dataclass
class _Function:
    """One function, and what is known of it so far."""

    node: ast.FunctionDef
    names: dict[str, Name]
    bundles: dict[str, list[str]]
    writes: set[Place] = field(default_factory=set)
    returns: set[Place] = field(default_factory=set)
    memory: dict[str, set[Place]] = field(default_factory=dict)  # local name -> arguments behind it
    parts: dict[str, dict[str, set[Place]]] = field(default_factory=dict)  # bundle -> fields

    def __post_init__(self) -> None:
        self.parameters = [a.arg for a in (*self.node.args.posonlyargs, *self.node.args.args)]
        # At first each parameter is known by its own name only.
        self.memory = {name: {(place, "")} for place, name in enumerate(self.parameters)}
        # The order of statements is ignored: repeating until nothing is new makes up for it.
        self._steps = [node for node in ast.walk(self.node) if isinstance(node, _STEPS)]

    def learn(self, functions: Mapping[Name, _Function]) -> bool:
        """Go through the body once; return whether anything is new."""
        before = self._size()
        for node in self._steps:
            if isinstance(node, ast.Assign):
                for target in node.targets:
                    self._assign_value(target, node.value, functions)
            elif isinstance(node, ast.For):
                self._assign(node.target, self._behind(node.iter, functions))
            elif isinstance(node, ast.AugAssign | ast.AnnAssign):
                self._augment(node)
            elif isinstance(node, ast.Return) and node.value is not None:
                self.returns |= self._behind(node.value, functions)
            elif isinstance(node, ast.Call):
                self._call(node, functions)
        # Sets only grow, so equal sizes mean that nothing was learned.
        return self._size() != before

    def _size(self) -> tuple[int, int, int]:
        return len(self.writes), len(self.returns), sum(map(len, self.memory.values()))

    def _assign_value(
        self, target: ast.expr, value: ast.expr, functions: Mapping[Name, _Function]
    ) -> None:
        """``a, b = c, d`` pair by pair; a new bundle field by field; anything else as a whole."""
        # Pair by pair, so that swapping two arrays does not mix up what lies behind them.
        if (
            isinstance(target, ast.Tuple)
            and isinstance(value, ast.Tuple)
            and len(target.elts) == len(value.elts)
        ):
            for part, source in zip(target.elts, value.elts, strict=True):
                self._assign_value(part, source, functions)
            return
        # A bundle that is made here: each field remembers its own arrays.
        if isinstance(target, ast.Name) and isinstance(value, ast.Call):
            fields = self.bundles.get(getattr(value.func, "id", ""), [])
            if fields:
                sources = [self._behind(part, functions) for part in value.args]
                self.parts[target.id] = dict(zip(fields, sources, strict=False))
        self._assign(target, self._behind(value, functions))

    def _assign(self, target: ast.expr, memory: set[Place]) -> None:
        if isinstance(target, ast.Tuple | ast.List):
            for part in target.elts:
                self._assign(part, memory)
        elif isinstance(target, ast.Name):
            # A name may be assigned several times: all arrays that it ever stood for.
            self.memory[target.id] = self.memory.get(target.id, set()) | memory
        # An assignment to an element writes the array.
        elif isinstance(target, ast.Subscript):
            self.writes |= self._behind(target.value, {})

    def _augment(self, node: ast.AugAssign | ast.AnnAssign) -> None:
        """``a[i] += 1`` writes a; so does ``a += 1``, where a is no number out of an array."""
        if isinstance(node.target, ast.Subscript):
            self.writes |= self._behind(node.target.value, {})
        elif isinstance(node.target, ast.Name) and node.target.id in self.parameters:
            self.writes.add((self.parameters.index(node.target.id), ""))

    def _behind(self, node: ast.expr, functions: Mapping[Name, _Function]) -> set[Place]:
        """Arguments whose memory an expression may be."""
        if isinstance(node, ast.Name):
            # A bundle as a whole is everything in its fields.
            parts = self.parts.get(node.id, {})
            return set(self.memory.get(node.id, ())).union(*parts.values())
        if isinstance(node, ast.Attribute):
            return self._part(node.value, node.attr, functions)
        # A part of an array is in the same memory.
        if isinstance(node, ast.Subscript | ast.Starred):
            return self._behind(node.value, functions)
        if isinstance(node, ast.Tuple | ast.List):
            return set().union(*(self._behind(part, functions) for part in node.elts))
        # Either branch may be taken.
        if isinstance(node, ast.IfExp):
            return self._behind(node.body, functions) | self._behind(node.orelse, functions)
        if not isinstance(node, ast.Call):
            return set()
        # A method of an array, or a function of numpy.
        if isinstance(node.func, ast.Attribute):
            if node.func.attr not in _SAME_MEMORY:
                return set()
            parts = [node.func.value, *node.args]
            return set().union(*(self._behind(part, functions) for part in parts))
        return self._from_call(node, functions, "returns")

    def _part(self, node: ast.expr, name: str, functions: Mapping[Name, _Function]) -> set[Place]:
        """Arguments behind a field of an expression; all of it where it is not a bundle."""
        if not name:
            return self._behind(node, functions)
        # A bundle of this function; a bundle that was passed in has fields by name.
        if isinstance(node, ast.Name) and node.id in self.parts:
            return self.parts[node.id].get(name, set())
        return {(place, old or name) for place, old in self._behind(node, functions)}

    def _call(self, node: ast.Call, functions: Mapping[Name, _Function]) -> None:
        if isinstance(node.func, ast.Attribute):
            if node.func.attr in _IN_PLACE:
                self.writes |= self._behind(node.func.value, functions)
            elif node.func.attr == "copyto":
                self.writes |= self._behind(node.args[0], functions)
            return
        self.writes |= self._from_call(node, functions, "writes")

    def _from_call(
        self, node: ast.Call, functions: Mapping[Name, _Function], what: str
    ) -> set[Place]:
        """Arguments of this function that come back from, or are written by, one it calls."""
        # A function that is no kernel, of numpy for example, writes no argument unless listed
        # above.
        called = functions.get(self.names.get(getattr(node.func, "id", ""), ("", "")))
        if called is None:
            return set()
        # Arguments by place and by name.
        handed = dict(enumerate(node.args))
        handed |= {called.parameters.index(k.arg): k.value for k in node.keywords if k.arg}
        touched: set[Place] = getattr(called, what)
        return set().union(
            *(self._part(handed[p], name, functions) for p, name in touched if p in handed)
        )
