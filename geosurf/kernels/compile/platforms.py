"""Platforms that kernels are frozen for: triple, levels of the CPU, object format, linker flags.

One row of `PLATFORMS` is everything that differs between platforms. The freezer reads how to make
a library (`triple`, `levels`, `format`), the loader which library to load and at which level
(`format.library`, `levels`), the build hook how the wheel is tagged (`wheel_tag`). A new platform
is a new row.

The build hook runs this file by its path, where geosurf is not installed: it imports nothing but
the standard library.
"""

from __future__ import annotations

import platform
import sys
from collections.abc import Mapping
from typing import NamedTuple


class ObjectFormat(NamedTuple):
    """What the format of objects and libraries decides.

    Attributes
    ----------
    library : str
        File name of the frozen library.
    exports_by_name : bool
        Whether kernels have to be marked as exported one by one, as in COFF.
    flags : tuple of str
        For the C compiler as linker: a symbol that is missing is an error of the linker, not of a
        user; neither debug information nor anything that differs from build to build.
    """

    library: str
    exports_by_name: bool
    flags: tuple[str, ...]


ELF = ObjectFormat(
    "kernels.so",
    False,
    (
        *("-fPIC", "-Wl,-z,defs", "-Wl,-z,noexecstack", "-Wl,-z,relro", "-Wl,--build-id=none"),
        *("-Wl,-s", "-lm"),
    ),
)
MACH_O = ObjectFormat(
    "kernels.dylib",
    False,
    # Without a name of its own the library would hold the path where it was linked.
    ("-fPIC", "-mmacosx-version-min=11.0", "-Wl,-install_name,@rpath/kernels.dylib", "-Wl,-S"),
)
COFF = ObjectFormat("kernels.dll", True, ("-Wl,-s",))


class Platform(NamedTuple):
    """One platform.

    Attributes
    ----------
    triple : str
        Of LLVM.
    levels : Mapping of str to int
        CPU of LLVM -> what `geosurf_level` of the library answers where it runs (`shim.c`); the
        most demanding one last. Results have the same bytes at all levels of a platform.
    format : ObjectFormat
    wheel_tag : str
        Platform of the wheel; on Linux `auditwheel` replaces it.
    zig : str
        Target of ``zig cc``, the linker for platforms other than this one. On Linux it names the
        oldest C library that the result has to run with.
    """

    triple: str
    levels: Mapping[str, int]
    format: ObjectFormat
    wheel_tag: str
    zig: str


_X86_64 = {"x86-64": 1, "x86-64-v3": 3}

# Names as `platform_name` gives them.
PLATFORMS: dict[str, Platform] = {
    "linux-x86_64": Platform(
        "x86_64-unknown-linux-gnu", _X86_64, ELF, "linux_x86_64", "x86_64-linux-gnu.2.17"
    ),
    "linux-aarch64": Platform(
        "aarch64-unknown-linux-gnu",
        {"generic": 1},
        ELF,
        "linux_aarch64",
        "aarch64-linux-gnu.2.17",
    ),
    # The M1 is the oldest Mac with an ARM processor.
    "darwin-arm64": Platform(
        "arm64-apple-macosx11.0.0",
        {"apple-m1": 1},
        MACH_O,
        "macosx_11_0_arm64",
        "aarch64-macos.11.0",
    ),
    "win32-x86_64": Platform(
        "x86_64-pc-windows-gnu", _X86_64, COFF, "win_amd64", "x86_64-windows-gnu"
    ),
}


def platform_name() -> str:
    """
    Return operating system and processor of this process as `PLATFORMS` has them.

    Examples
    --------
    >>> platform_name().split("-")[0] == sys.platform
    True
    """
    return f"{sys.platform}-{platform.machine().lower().replace('amd64', 'x86_64')}"
