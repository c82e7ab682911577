"""An installed wheel, tried: frozen kernels, no numba, a faulted model from files to files.

Run by `cibuildwheel` and by hand, with the Python that the wheel is installed in. It needs no
package beside those of the wheel::

    python tests/package/installed_wheel.py
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NUMBA = ("numba", "llvmlite")
RESULTS = ("units.vtm", "curves.vtp", "volumes.csv", "certificate.txt", "report/index.html")


def main() -> None:
    """Build the faulted reservoir of the demo with the library of the wheel."""
    # a module that is None counts as not installed
    sys.modules.update(dict.fromkeys(NUMBA))  # type: ignore[arg-type]
    import geosurf as gs
    from geosurf.kernels.compile.jit import RUNNER

    place = Path(gs.__file__).parent
    assert ROOT not in place.parents, f"{place} is the checkout: run this outside of it"
    assert not RUNNER.compiles, RUNNER.describe()

    # tables of volumes as csv: NetCDF needs an extra
    world, folder = gs.synthetic.graben(n=33), Path(tempfile.mkdtemp())
    tables = []
    for kind, surfaces in (("horizons", world.horizons), ("faults", world.faults)):
        for name, one in surfaces.items():
            mesh = gs.triangulate_fault(one, name=name) if kind == "faults" else one
            file = f"{name}.ts" if kind == "faults" else f"{name}.gri"
            gs.write(mesh, folder / file)
            tables.append(f'[[{kind}]]\nname = "{name}"\nfile = "{file}"\npositive = "up"\n')
    tables.append('[output]\nformats = ["vtm", "vtp", "csv"]\n')
    (folder / "scenario.toml").write_text("".join(tables), encoding="utf-8")
    with warnings.catch_warnings(action="ignore", category=gs.GeosurfWarning):
        scene = gs.run_scenario(folder / "scenario.toml", folder / "out")
    assert scene.check().ok
    for name in RESULTS:
        assert (folder / "out" / name).stat().st_size > 100, name
    west, east, south, north, low, high = scene.box
    box, units = (east - west) * (north - south) * (high - low), float(scene.units.volumes.sum())
    assert abs(units / box - 1.0) < 1e-9, (units, box)
    lines = (place, RUNNER.describe(), f"{len(scene.units)} units fill the box; certificate valid.")
    sys.stdout.write("".join(f"{line}\n" for line in lines))


if __name__ == "__main__":
    main()
