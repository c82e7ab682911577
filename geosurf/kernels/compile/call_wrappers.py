"""C functions that call frozen kernels, one for each list of arguments that a kernel has.

A kernel takes seven words or more for each array. ctypes makes an object of each word of a call,
which took longer than most kernels. So a call has four words: the kernel, its results, its failure,
and a block with one word for each argument. Arrays are words of the array interface of numpy.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

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
    for k, one in enumerate(letters):
        if len(one) == 1:
            types.append(_TYPES[one])
            values.append(f"w[{k}].real" if one == "d" else f"({_TYPES[one]})w[{k}].whole")
            continue
        # no owner and no parent: Python keeps the memory alive during the call
        of, dims = f"w[{k}].array->", range(int(one[1]))
        types += ["void *", "void *", "int64_t", "int64_t", "void *", *["int64_t"] * 2 * len(dims)]
        values += ["0", "0", f"size(w[{k}].array)", f"{of}item_size", f"{of}data"]
        values += [f"{of}{word}[{i}]" for word in ("shape", "strides") for i in dims]
    return (
        f"PUBLIC int32_t {wrapper(letters)}(void *kernel, void *results, void **failure, "
        "const word *w)\n{\n"
        f"    typedef int32_t body({', '.join(types)});\n"
        f"    return ((body *)kernel)({', '.join(values)});\n}}\n"
    )
