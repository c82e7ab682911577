"""TetGen in a process of its own, which runs this file: it imports numpy and tetgen alone.

TetGen writes ``_skipped.node`` and ``_skipped.face`` into the current folder when it refuses faces,
cannot be interrupted, and does not end on some models. The folder of a process is its own, and a
process can be stopped.

Arguments: none. ``boundary.npz`` in the current folder holds ``x``, ``faces`` and the options as
JSON; the process writes ``mesh.npz``, or ``error.txt`` with the message of TetGen.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np


def main() -> None:
    """Run TetGen once."""
    import tetgen

    given = np.load("boundary.npz")
    faces = given["faces"]
    try:
        run = tetgen.TetGen(given["x"], faces, np.arange(1, len(faces) + 1, dtype=np.int32))
        run.tetrahedralize(**json.loads(str(given["options"])))
    except (RuntimeError, ValueError, MemoryError) as error:
        Path("error.txt").write_text(str(error), encoding="utf-8")
        return
    np.savez(
        "mesh.npz", node=run.node, elem=run.elem, trifaces=run.trifaces, markers=run.triface_markers
    )


if __name__ == "__main__":
    main()
