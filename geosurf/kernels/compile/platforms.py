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
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

# ---- call wrappers ----------------------------------------
# C functions that call frozen kernels, one for each list of arguments that a kernel has.
#
# A kernel takes seven words or more for each array. ctypes makes an object of each word of a call,
# which took longer than most kernels. So a call has four words: the kernel, its results, its
# failure, and a block with one word for each argument. Arrays are words of the array interface of
# numpy.


_HEAD = """\
#include <stdint.h>

#if defined(_WIN32)
#define PUBLIC __declspec(dllexport)
#else
#define PUBLIC __attribute__((visibility("default")))
#endif

/* As numpy hands arrays over: "The array interface protocol", `__array_struct__`. */
typedef struct {
    int two, n_dim;
    char kind;
    int item_size, flags;
    intptr_t *shape, *strides;
    void *data;
} array;

typedef union {
    int64_t whole;
    double real;
    const array *array;
} word;

static int64_t size(const array *a)
{
    int64_t n = 1;
    for (int i = 0; i < a->n_dim; i++)
        n *= a->shape[i];
    return n;
}
"""
_TYPES = {"d": "double", "l": "int64_t", "b": "int8_t"}


def wrapper(letters: Sequence[str]) -> str:
    """Return the name of the function that calls kernels with these arguments.

    Examples
    --------
    >>> wrapper(("d2", "l"))
    'geosurf_call_d2_l'
    """
    return "_".join(["geosurf_call", *letters])


def source_of_wrappers(kernels: Iterable[Sequence[str]]) -> str:
    """Return a C file with the functions for the arguments of some kernels, each once.

    Parameters
    ----------
    kernels : iterable of sequence of str
        Letters of their arguments, as in `Signature`.

    Examples
    --------
    >>> source_of_wrappers([("l", "b"), ("l", "b")]).count("geosurf_call_l_b(")
    1
    """
    return "\n".join([_HEAD, *map(_function, sorted({tuple(letters) for letters in kernels}))])


def _function(letters: tuple[str, ...]) -> str:
    types, values = ["void *", "void **"], ["results", "failure"]
    for k, letter in enumerate(letters):
        if len(letter) == 1:
            types.append(_TYPES[letter])
            values.append(f"w[{k}].real" if letter == "d" else f"({_TYPES[letter]})w[{k}].whole")
            continue
        # no owner and no parent: Python keeps the memory alive during the call
        field, dims = f"w[{k}].array->", range(int(letter[1]))
        types += ["void *", "void *", "int64_t", "int64_t", "void *", *["int64_t"] * 2 * len(dims)]
        values += ["0", "0", f"size(w[{k}].array)", f"{field}item_size", f"{field}data"]
        values += [f"{field}{word}[{i}]" for word in ("shape", "strides") for i in dims]
    return (
        f"PUBLIC int32_t {wrapper(letters)}(void *kernel, void *results, void **failure, "
        "const word *w)\n{\n"
        f"    typedef int32_t body({', '.join(types)});\n"
        f"    return ((body *)kernel)({', '.join(values)});\n}}\n"
    )


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
        "aarch64-unknown-linux-gnu", {"generic": 1}, ELF, "linux_aarch64", "aarch64-linux-gnu.2.17"
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
