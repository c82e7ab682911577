"""Object files for platforms other than this one: formats, exports, no fused rounding."""

from __future__ import annotations

import json
import struct

import pytest

from geosurf.kernels.compile.freeze import _forget_time
from geosurf.kernels.compile.platforms import PLATFORMS
from tests.processes import told_by

pytestmark = pytest.mark.long  # of the compile machinery: an edit of kernels, not of the model

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
