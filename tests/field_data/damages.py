"""Count wrong answers to damage: ``python -m tests.field_data.damages [cases] [seconds] [first]``.

Meshes with one or two of the damages of `test_fuzz` meet a whole mesh (grids: `spoiled`): an
error of ours, or a result that its certificate calls right. What is not harmed must not be refused,
and what is beyond use must be. A case that takes half a minute ends the run with a traceback, as a
crash does; it stops after so many seconds, if they are given, and ends with 1 if a case is wrong.
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
from tests.field_data.test_fuzz import DAMAGES, whole, whole_way

HARMLESS = {
    "nothing", "float32", "lists", "objects", "Fortran order", "read-only, with strides", "int8",
    "uint64", "UTM", "every vertex twice", "every triangle twice",
}  # fmt: skip
HOPELESS = {
    "infinite", "beyond all bounds", "words", "complex", "nan", "two columns",
    "one row of numbers", "edges for triangles", "indices with fractions", "a negative index",
    "an index too large", "a huge index", "a corner twice", "no triangles", "nothing at all",
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
    mesh, done = damaged_mesh(rng)
    second = whole(int(rng.integers(4)), rng)
    done.append(flat_or_not(second, "flat for good"))
    if seed % 8 == 0:
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
