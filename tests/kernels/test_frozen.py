"""Frozen kernels against the same ones compiled here and as plain Python; gate; memory; threads."""

from __future__ import annotations

import copy
import json
import re
import resource
import shutil
import struct
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geosurf.errors import DependencyError, InputError
from geosurf.kernels.compile import freeze, jit, object_files
from geosurf.kernels.compile.freeze import _forget_time
from geosurf.kernels.compile.frozen_runner import MANIFEST, FrozenRunner, Library, Unfit, stamp_of
from geosurf.kernels.compile.gate import PlainRunner
from geosurf.kernels.compile.jit import Entry
from geosurf.kernels.compile.numba_runner import JitRunner
from geosurf.kernels.compile.platforms import PLATFORMS, platform_name
from tests import processes
from tests.kernels import frozen
from tests.kernels.tiny import basic
from tests.messages import refused
from tests.processes import told_by

pytestmark = pytest.mark.long  # of the compile machinery: an edit of kernels, not of the model

TINY = "tests.kernels.tiny"
STAMP = stamp_of(frozen.folder_of(TINY))
LEVELS = ("x86-64", "x86-64-v3")
LIBRARY = frozen.library_name()


@pytest.fixture(scope="module")
def library() -> Path:
    return frozen.frozen(TINY)


@pytest.fixture(scope="module", params=["plain", "jit", *LEVELS])
def runner(request, tmp_path_factory) -> Any:
    """Each way to run a kernel, and each level of frozen code that this CPU knows."""
    if request.param == "plain":
        return PlainRunner("a test asks for it")
    if request.param == "jit":
        return JitRunner("a test asks for it")
    folder = request.getfixturevalue("library")
    folder = frozen.only_level(folder, tmp_path_factory.mktemp("level") / "one", request.param)
    try:
        return FrozenRunner(Library(folder, STAMP))
    except Unfit as unfit:
        pytest.skip(str(unfit))


def ways(runner: Any) -> Callable[..., Any]:
    """The tiny kernels as one runner runs them."""
    return lambda name: Entry(getattr(basic, name).python, getattr(basic, name).signature, runner)


@pytest.fixture
def kernel(runner) -> Callable[..., Any]:
    return ways(runner)


@pytest.fixture
def machine(library) -> Callable[..., Any]:
    return ways(FrozenRunner(Library(library, STAMP)))


# ---- the same bits -----------------------------------------------------------------------


X = np.array([[0.1, 0.7, -3.0], [1e300, 1e-300, 0.0], [5e-324, -0.0, 2.0 / 3.0]])
CALLS: dict[str, list[tuple[Any, ...]]] = {
    "kinds": [
        (X, np.array([2, 0, 1, 0]), True, 0.3),
        (X, np.array([2]), False, -1.0 / 3.0),
        (X, np.empty(0, dtype=np.int64), False, 0.0),
        (np.empty((3, 0)), np.array([1]), True, 1.0),
    ],
    "flip": [(np.array([True, False, True]),), (np.empty(0, dtype=bool),)],
    "crossed": [(X,), (X[:2].copy(),)],
    "shared": [(np.array([2**62, -1, 0]),)],
    "parts": [(0.3,), (-0.0,), (5e-324,), (1.7e308,)],
    "room": [(1,), (3,)],
    "order": [(np.array([3.0, -1.0, 2.5] * 40) + np.arange(120) / 7,)],
    "grow": [(0,), (5000,)],
    "spin": [(1000, np.zeros(1, dtype=np.int64))],
    "widen": [(1,), (2,)],
    "fill": [(np.zeros(4), -3)],
}


@pytest.mark.parametrize("name", CALLS)
def test_all_ways_give_the_same_bits(name, kernel):
    for arguments in CALLS[name]:
        mine, theirs = copy.deepcopy(arguments), copy.deepcopy(arguments)
        plain = ways(PlainRunner("it is the reference"))(name)
        assert_same(kernel(name)(*mine), plain(*theirs))
        for one, other in zip(mine, theirs, strict=True):  # what they have written
            assert_same(one, other)


def assert_same(one: Any, other: Any) -> None:
    """Same types, shapes and bytes; an array from room() has undefined elements but the first."""
    if isinstance(other, tuple):
        assert isinstance(one, tuple)
        assert len(one) == len(other)
        for mine, theirs in zip(one, other, strict=True):
            assert_same(mine, theirs)
    elif isinstance(other, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape)
        assert one.strides == other.strides or one.size == 0
        assert one.flags.writeable
        assert one.flat[:1].tobytes() == other.flat[:1].tobytes()
        if other.ndim != 1 or other[:1].tolist() != [1]:
            assert one.tobytes() == other.tobytes()
    else:
        assert np.array(one).tobytes() == np.array(other).tobytes()


def test_an_argument_that_comes_back_is_itself(kernel):
    out = np.zeros(4)
    whole, part = kernel("fill")(out, 5)
    assert whole.tolist() == [5.0] * 4
    part[0] = 7.0
    assert out.tolist() == [5.0, 7.0, 5.0, 5.0]


@pytest.mark.parametrize(
    ("name", "argument", "error", "text"),
    [
        ("refuse", -1, ValueError, "negative"),
        ("room", -1, ValueError, "negative dimensions"),
        ("room", 2**59, (MemoryError, ValueError), "."),
        ("room", 2**62, ValueError, "."),
        ("widen", 3, ValueError, "assign slice|broadcast"),
    ],
)
def test_exceptions_come_out_as_they_are(name, argument, error, text, kernel):
    for _ in range(3):
        refused(error, text, lambda: kernel(name)(argument))
    assert kernel("refuse")(3) == 3


def test_an_exception_says_where_but_no_folder(machine):
    with pytest.raises(OverflowError) as caught:
        machine("refuse")(7)
    assert caught.value.args == ("seven", 7)
    (note,) = caught.value.__notes__
    assert re.fullmatch(r"raised by the compiled kernel basic.refuse \(basic.py, line \d+\)", note)


# ---- the gate ----------------------------------------------------------------------------


ROWS = np.array([2, 0, 1])
TABLE = np.arange(12.0).reshape(3, 4)
CAST = {
    "float32": TABLE.astype(np.float32),
    "whole numbers": TABLE.astype(np.int16),
    "list": TABLE.tolist(),
    "strided": np.repeat(TABLE, 2, axis=1)[:, ::2],
    "backwards": TABLE[::-1].copy()[::-1],
    "Fortran": np.asfortranarray(TABLE),
    "other byte order": TABLE.astype(">f8"),
    "not aligned": np.frombuffer(b"\0" + TABLE.tobytes(), dtype=np.uint8)[1:]
    .view(np.float64)
    .reshape(3, 4),
    "matrix": np.ma.masked_array(TABLE),
}
READ_ONLY = TABLE.copy()
READ_ONLY.flags.writeable = False
CAST["read-only"] = READ_ONLY


@pytest.mark.parametrize("case", CAST)
def test_what_can_be_cast_is_cast(case, kernel):
    sums, n, largest = kernel("kinds")(CAST[case], ROWS.astype(np.int32), 1, 0)
    assert (sums.tolist(), n, largest) == ([76.0, 12.0, 44.0], 3, 76.0)


REFUSED = {
    "one dimension": ((TABLE[0], ROWS, True, 0.0), "argument 0 has 1 dimensions, expected 2"),
    "three dimensions": ((TABLE[None], ROWS, True, 0.0), "argument 0 has 3 dimensions"),
    "a number": ((1.0, ROWS, True, 0.0), "argument 0 has 0 dimensions"),
    "complex": ((TABLE * 1j, ROWS, True, 0.0), "argument 0 is complex128, expected float64"),
    "words": ((np.array([["a"]]), ROWS, True, 0.0), "argument 0 is <U1, expected float64"),
    "rows with a fraction": ((TABLE, ROWS + 0.5, True, 0.0), "argument 1 is float64"),
    "an array as number": ((TABLE, ROWS, True, TABLE), "scalar"),
    "none": ((TABLE, None, True, 0.0), "argument 1 has 0 dimensions"),
    "too few": ((TABLE, ROWS), "kinds takes 4 arguments, 2 were given"),
}


@pytest.mark.filterwarnings("ignore:Conversion of an array")
@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_cast_is_refused(case, kernel):
    arguments, text = REFUSED[case]
    refused(TypeError, text, lambda: kernel("kinds")(*arguments))


WRITTEN = {
    "float32": np.zeros(4, dtype=np.float32),
    "list": [0.0, 0.0],
    "strided": np.zeros(8)[::2],
    "read-only": READ_ONLY[0],
    "other byte order": np.zeros(4, dtype=">f8"),
}


@pytest.mark.parametrize("case", WRITTEN)
def test_what_is_written_has_to_be_fit_as_it_is(case, kernel):
    """A cast would write into a copy, and nobody would see the result."""
    with pytest.raises(TypeError, match="fill: argument 0 is written; expected an aligned C array"):
        kernel("fill")(WRITTEN[case], 1)
    refused(TypeError, "2 dimensions, expected 1", lambda: kernel("fill")(np.zeros((2, 2)), 1))


@pytest.mark.parametrize("number", [2**63, -(2**63) - 1])
def test_numbers_that_do_not_fit_are_refused(number, kernel):
    refused(OverflowError, "64 bits", lambda: kernel("refuse")(number))
    with pytest.raises(TypeError):
        kernel("refuse")(2.5)  # nor is it cut
    assert kernel("refuse")(np.int8(2)) == 2


# ---- memory and threads --------------------------------------------------------------------


def test_results_are_given_back(machine):
    """A gigabyte in all would show, if it were kept."""
    shared, order, grow = machine("shared"), machine("order"), machine("grow")
    table = np.zeros(500_000, dtype=np.int64)
    shared(table)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(250):
        one, other = shared(table)
        del one
        assert other[-1] == 1
        order(table[:2000].astype(float))
        grow(20_000)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000  # kB


def test_others_can_run_meanwhile(machine):
    """With the lock held, the loop below would not turn before the thread has ended."""
    spin, out = machine("spin"), np.zeros(1, dtype=np.int64)
    thread = threading.Thread(target=spin, args=(50_000_000, out))
    thread.start()
    turns = 0
    while thread.is_alive() and turns < 20:
        thread.join(timeout=0.001)
        turns += 1
    thread.join()
    assert turns >= 5
    assert out[0] != 0


# ---- which library is used -----------------------------------------------------------------


def test_a_library_that_does_not_fit_says_why(library, tmp_path):
    def copied(name: str, **changes: Any) -> Path:
        shutil.copytree(library, tmp_path / name)
        manifest = json.loads((library / MANIFEST).read_text()) | changes
        (tmp_path / name / MANIFEST).write_text(json.dumps(manifest))
        return tmp_path / name

    cut = copied("cut")
    (cut / LIBRARY).write_bytes((library / LIBRARY).read_bytes()[:5000])
    gone = copied("gone")
    (gone / LIBRARY).unlink()
    torn = copied("torn")
    (torn / MANIFEST).write_text("{")
    cases = [
        (tmp_path / "nowhere", STAMP, "has no frozen library"),
        (torn, STAMP, "manifest of the frozen library cannot be read"),
        (copied("other", platform="beos-ppc"), STAMP, "is for beos-ppc"),
        (library, "0" * 64, "was made from other sources"),
        (cut, STAMP, "library and its manifest do not belong together"),
        (copied("mixed", sha256="0" * 64), STAMP, "do not belong together"),
        (gone, STAMP, "frozen library cannot be loaded"),
    ]
    for folder, stamp, text in cases:
        refused(Unfit, text, Library, folder, stamp)


def test_a_chosen_library_that_does_not_fit_is_an_error(library, monkeypatch):
    """Left alone, geosurf compiles; told to use a library, it must not do something else."""
    for variable in ("NUMBA_DISABLE_JIT", "GEOSURF_JIT"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("GEOSURF_FROZEN", str(library))
    refused(DependencyError, r"GEOSURF_FROZEN=.*made from other sources\. Unset", jit.choose)
    monkeypatch.setenv("GEOSURF_JIT", "1")
    assert "since GEOSURF_JIT is set" in jit.choose().describe()
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    assert "plain Python" in jit.choose().describe()


def test_without_numba_nothing_imports_it():
    """The kernels of all rooms, as plain Python: the same imports as with a frozen library."""
    code = (
        "import sys, geosurf.rebuild, geosurf.carve, geosurf.intersect as room\n"
        "print(*{'numba', 'llvmlite', 'xarray', 'pandas', 'scipy'} & set(sys.modules))"
    )
    chosen = ("GEOSURF_JIT", "GEOSURF_FROZEN")
    assert told_by("-c", code, without=chosen, NUMBA_DISABLE_JIT="1").split() == []


# ---- freezing ------------------------------------------------------------------------------


def test_the_library_names_no_folder_and_needs_no_python(library):
    held = (library / LIBRARY).read_bytes() + (library / MANIFEST).read_bytes()
    for folder in (processes.ROOT, Path(sys.prefix), Path(sys.base_prefix), Path.home()):
        if len(folder.parts) > 1:
            assert str(folder).encode() not in held
    assert not re.search(rb"site-packages|libpython|Py[A-Z][a-z]+_", held)


def test_no_compiler_is_said(monkeypatch, tmp_path):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    refused(DependencyError, "no C compiler here", freeze.find_compiler)
    assert freeze.main(["--out", str(tmp_path / "out")]) == freeze.NOT_HERE
    monkeypatch.setattr(freeze, "platform_name", lambda: "beos-ppc")
    refused(DependencyError, r"frozen for linux-x86_64, .* not for beos-ppc", freeze.find_compiler)


def test_a_kernel_that_needs_more_than_we_bring_is_refused():
    llvm = pytest.importorskip("llvmlite.binding")
    module = llvm.parse_assembly(
        "declare i8* @NRT_MemInfo_new(i8*, i64)\n"
        "declare void @memcpy()\n"
        "declare double @llvm.floor.f64(double)\n"
    )
    with pytest.raises(InputError, match=r"kernel room calls NRT_MemInfo_new, which a frozen"):
        object_files.refuse_foreign("room", module)


@pytest.mark.slow
@pytest.mark.skipif(platform_name() not in PLATFORMS, reason="nothing is frozen here")
def test_two_builds_give_the_same_bytes(library, tmp_path):
    freeze.freeze(tmp_path / "again", TINY)
    assert (tmp_path / "again" / LIBRARY).read_bytes() == (library / LIBRARY).read_bytes()


# ---- Object files for platforms other than this one: formats, exports, no fused rounding.
# a * b + c, which a processor with fused multiply-add could round once instead of twice
_MODULE = """
define i32 @"geosurf_kernel.room.sum"(double* %r, i8** %e, double %a, double %b, double %c) {
  %p = fmul double %a, %b
  %s = fadd double %p, %c
  store double %s, double* %r
  ret i32 0
}
"""
_CODE = """
import json, sys
import llvmlite.binding as llvm
from geosurf.kernels.compile.object_files import emit
from geosurf.kernels.compile.platforms import PLATFORMS
text = sys.stdin.read()
bitcode = llvm.parse_assembly(text).as_bitcode()
names = [(name, level) for name, row in PLATFORMS.items() for level in row.levels]
print(json.dumps([(*name, emit(bitcode, *name).hex()) for name in names]))
"""
_STARTS = {
    "linux-x86_64": b"\x7fELF",
    "linux-aarch64": b"\x7fELF",
    "darwin-arm64": b"\xcf\xfa\xed\xfe\x0c\x00\x00\x01",  # 64 bits, ARM
    "win32-x86_64": b"\x64\x86",
}


@pytest.fixture(scope="module")
def objects() -> dict[tuple[str, str], bytes]:
    """One object for each platform and level, in a process of its own: numba's machine changes."""
    pytest.importorskip("llvmlite")
    held = json.loads(told_by("-c", _CODE, said=_MODULE))
    return {(name, level): bytes.fromhex(code) for name, level, code in held}


def test_each_platform_gets_its_format_and_a_symbol_for_each_level(objects):
    for (name, level), held in objects.items():
        assert held.startswith(_STARTS[name])
        assert f"{level}__room__sum".replace("-", "_").encode() in held
        # COFF exports what is named in the object.
        assert (b"-export:" in held) == PLATFORMS[name].format.exports_by_name
    assert len(objects) == sum(len(row.levels) for row in PLATFORMS.values())


def test_products_and_sums_are_rounded_one_by_one(objects):
    """The exact predicates break where a * b + c is rounded once."""
    fmul, fadd = 0x1E610800, 0x1E622800  # d0 = d0 * d1; d0 = d0 + d2
    for name in ("linux-aarch64", "darwin-arm64"):
        (held,) = [held for (platform, _), held in objects.items() if platform == name]
        words = {struct.unpack_from("<I", held, i)[0] for i in range(0, len(held) - 3, 4)}
        assert {fmul, fadd} <= words
    # vfmadd and its relatives begin with these two bytes.
    assert b"\xc4\xe2" not in objects["linux-x86_64", "x86-64-v3"]


def test_a_library_of_windows_forgets_when_it_was_linked(tmp_path):
    """A header with one section that holds the table of exports, times at both places."""
    raw = bytearray(b"\x07" * 1024)
    struct.pack_into("<I", raw, 0x3C, 64)
    struct.pack_into("<2xH12xH", raw, 64 + 4, 1, 240)
    struct.pack_into("<I", raw, 64 + 24 + 112, 0x1010)
    struct.pack_into("<8xIIII", raw, 64 + 24 + 240, 0x200, 0x1000, 0x200, 0x200)
    (tmp_path / "kernels.dll").write_bytes(raw)
    _forget_time(tmp_path / "kernels.dll")
    for place in (64 + 8, 0x210 + 4):
        struct.pack_into("<I", raw, place, 0)
    assert (tmp_path / "kernels.dll").read_bytes() == bytes(raw)
