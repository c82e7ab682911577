"""Count wrong answers to damage: ``python -m tests.field_data.damages [cases] [seconds] [first]``.

Meshes with one or two of the damages of `test_fuzz`, and lattices with those below, meet a whole
mesh: an error of ours, or a result that its certificate calls right. What is not harmed must not be
refused, and what is beyond use must be. A case that takes half a minute ends the run with a
traceback, as a crash does; it stops after so many seconds, if they are given, and ends with 1 if a
case is wrong.
"""

from __future__ import annotations

import sys
import warnings

import numpy as np

import geosurf as gs
from geosurf.carve.certificate import certify
from geosurf.errors import GeosurfError, InvariantError
from tests import oracles
from tests.counting import count
from tests.field_data.test_fuzz import DAMAGES, put, read_only, whole, whole_way


def nodes(rng):
    """Easting, northing and elevation of a small grid; half of them with a node for each cell."""
    n_row, n_col = rng.integers(2, 6, 2)
    x, y = np.arange(float(n_col)), np.arange(float(n_row))
    if rng.random() < 0.5:
        x, y = np.meshgrid(x, y)
        x, y = x + 0.5 * y, y - 0.25 * x
    return x, y, 0.5 * rng.integers(-2, 3, (n_row, n_col))


def first(array, value):
    """A copy with its first number changed."""
    return put(array, (0,) * np.ndim(array), value)


def turned(x, y, z):
    """Axes fall, or rows are taken from the end."""
    return x[..., ::-1], y[::-1], z[::-1]


def masked(x, y, z):
    """An undefined value under a mask."""
    return x, y, np.ma.masked_array(put(z, (0, 0), 1e30), mask=put(z * 0, (0, 0), 1))


LATTICE_DAMAGES = {
    "nothing": lambda x, y, z: (x, y, z),
    "falling axes": turned,
    "a place twice": lambda x, y, z: (first(x, x.flat[1]), y, z),
    "a row twice": lambda x, y, z: (x, put(y, 0, y[1]), z),
    "axes go back and forth": lambda x, y, z: (np.abs(x - 1.5), y, z),
    "all in one place": lambda x, y, z: (x * 0, y * 0, z * 0),
    "upright": lambda x, y, z: (x, y * 0, z),
    "one row": lambda x, y, z: (x if x.ndim == 1 else x[:1], y[:1], z[:1]),
    "one column": lambda x, y, z: (x[..., :1], y if y.ndim == 1 else y[:, :1], z[:, :1]),
    "one node": lambda x, y, z: (x[..., :1][:1], y[:1][..., :1], z[:1, :1]),
    "no nodes": lambda x, y, z: ([], [], np.empty((0, 0))),
    "no rows": lambda x, y, z: (x[:0] if x.ndim == 2 else x, y[:0], z[:0]),
    "nothing defined": lambda x, y, z: (x, y, z * np.nan),
    "every second node": lambda x, y, z: (
        x, y, np.where(np.add.outer(*map(np.arange, z.shape)) % 2, z, np.nan)
    ),
    "a node undefined": lambda x, y, z: (x, y, first(z, np.nan)),
    "a place undefined": lambda x, y, z: (first(x, np.nan), y, z),
    "no place defined": lambda x, y, z: (x * np.nan, y, z),
    "infinite": lambda x, y, z: (x, y, first(z, np.inf)),
    "infinitely far": lambda x, y, z: (x, first(y, -np.inf), z),
    "undefined as a number": lambda x, y, z: (x, y, first(z, 1e30)),
    "masked": masked,
    "huge": lambda x, y, z: (1e15 * x, 1e15 * y, z),
    "beyond all bounds": lambda x, y, z: (x, 1e300 * y, z),
    "tiny": lambda x, y, z: (1e-200 * x, 1e-200 * y, 1e-200 * z),
    "subnormal": lambda x, y, z: (1e-320 * x, 1e-320 * y, 1e-320 * z),
    "tiny steps": lambda x, y, z: (1.0 + 2.0**-50 * x, y, z),
    "flat ones": lambda x, y, z: (x, 1e-300 * y, z),
    "axes exchanged": lambda x, y, z: (y, x, z),
    "axes too long": lambda x, y, z: (np.arange(99.0), y, z),
    "axes too short": lambda x, y, z: (x[..., :-1], y, z),
    "one axis for all": lambda x, y, z: (x, np.zeros(z.shape) if y.ndim == 1 else y[:, 0], z),
    "heights in a line": lambda x, y, z: (x, y, z.ravel()),
    "heights in layers": lambda x, y, z: (x, y, z[None]),
    "a number": lambda x, y, z: (1.0, 2.0, 3.0),
    "none": lambda x, y, z: (None, y, z),
    "ragged": lambda x, y, z: (x, y, [[1.0, 2.0], [3.0]]),
    "words": lambda x, y, z: (x, y, np.full(z.shape, "deep")),
    "complex": lambda x, y, z: (x + 1j, y, z),
    "objects": lambda x, y, z: (x, y, z.astype(object)),
    "whole numbers": lambda x, y, z: (x.astype(np.int8), y, (2 * z).astype(np.int16)),
    "float32": lambda x, y, z: (x, y, z.astype(np.float32)),
    "yes and no": lambda x, y, z: (x, y, z > 0),
    "dates": lambda x, y, z: (x, y, np.full(z.shape, np.datetime64("2001-01-01"))),
    "Fortran order": lambda x, y, z: (np.asfortranarray(x), y, np.asfortranarray(z)),
    "read-only, with strides": lambda x, y, z: tuple(map(read_only, (x, y, z))),
    "negative zeros": lambda x, y, z: (x, y, -0.0 * z),
    "lists": lambda x, y, z: (x.tolist(), y.tolist(), z.tolist()),
}  # fmt: skip


HARMLESS = {
    "nothing", "falling axes", "a node undefined", "masked", "negative zeros", "float32", "lists",
    "objects", "whole numbers", "Fortran order", "read-only, with strides", "int8", "uint64", "UTM",
    "every vertex twice", "every triangle twice", "tiny steps",
}  # fmt: skip
HOPELESS = {
    "one node", "no nodes", "no rows", "nothing defined", "every second node", "no place defined",
    "infinite", "infinitely far", "undefined as a number", "beyond all bounds", "axes too long",
    "all in one place", "heights in a line", "heights in layers", "a number", "none", "ragged",
    "words", "complex", "dates", "nan", "two columns", "one row of numbers", "edges for triangles",
    "indices with fractions", "a negative index", "an index too large", "a huge index",
    "a corner twice", "no triangles", "nothing at all",
}  # fmt: skip


def damaged_mesh(rng):
    """Vertices and triangles with one damage, or with a second where it can still be done; and
    what was done.
    """
    mesh = whole(int(rng.integers(4)), rng)
    done = [flat_or_not(mesh, "flat")]
    for name in rng.choice(list(DAMAGES), rng.integers(1, 3)):
        try:
            with warnings.catch_warnings(action="ignore"):
                mesh = DAMAGES[name](*(np.asarray(part) for part in mesh))
        except (IndexError, OverflowError, TypeError, ValueError):
            break
        done.append(str(name))
    return mesh, done


def damaged_lattice(kind: str, done: list[str], rng):
    """A surface from a damaged grid, one time in three turned over or along the other diagonal."""
    whole_grid = nodes(rng)
    if kind in ("a node undefined", "masked") and whole_grid[2].size == 4:
        done.append("no triangle, if its diagonal ends there")
    lattice = gs.Lattice(
        *LATTICE_DAMAGES[kind](*whole_grid),
        bool(rng.integers(2)),
        (None, True, False)[rng.integers(3)],
    )
    return gs.TriSurface("A", "fault", lattice=lattice)


def flat_or_not(mesh, word: str) -> str:
    """What a whole mesh may have of its own: a triangle without an area."""
    x, t = mesh
    return word if any(oracles.flat(x[corners]) for corners in t) else "nothing"


def meets(surface, second):
    """The certificate of a surface with another, and its curves in either order."""
    pair = [surface, gs.TriSurface("B", "fault", *second)]
    one, two = (gs.intersect_surfaces(p, self_intersections=True) for p in (pair, pair[::-1]))
    assert one.n_curve == two.n_curve, "the order of the surfaces matters"
    return certify(gs.rebuild_surfaces(pair, self_intersections=True))


def case_of(seed: int):
    """What is damaged, by name, and how to get its certificate."""
    rng = np.random.default_rng([21, seed])
    if seed % 2:
        kind = list(LATTICE_DAMAGES)[(seed // 2) % len(LATTICE_DAMAGES)]
        second = whole(int(rng.integers(4)), rng)
        done = [kind, flat_or_not(second, "flat for good")]
        return done, lambda: meets(damaged_lattice(kind, done, rng), second)
    mesh, done = damaged_mesh(rng)
    second = whole(int(rng.integers(4)), rng)
    done.append(flat_or_not(second, "flat for good"))
    if seed % 16 == 0:
        return done, lambda: whole_way(mesh, second)
    return done, lambda: meets(gs.TriSurface("A", "fault", *mesh), second)


def what_becomes_of(seed: int) -> tuple[str, str]:
    """One of "right", "refused" and "wrong", and why it is wrong."""
    done, answer_of = case_of(seed)
    try:
        answer = answer_of()
    except GeosurfError as error:
        if isinstance(error, InvariantError):
            return "wrong", f"{type(error).__name__}: {error}"
        if set(done) <= HARMLESS:
            return "wrong", f"{done} is no reason to refuse: {error}"
        return "refused", ""
    except Exception as error:  # what is not ours is wrong
        return "wrong", f"{type(error).__name__}: {error}"
    real = set(done) - {"nothing"}
    if "flat for good" in real or (len(real) == 1 and real <= HOPELESS):
        return "wrong", f"{done} is used as if it were whole"
    return ("right", "") if answer.ok else ("wrong", str(answer))


if __name__ == "__main__":
    what_becomes_of(0)  # kernels are compiled in no case's time
    sys.exit(count(what_becomes_of))
