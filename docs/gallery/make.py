"""Draw the pictures of the documentation: ``python docs/gallery/make.py [names of scripts]``.

Every script writes its picture to ``docs/pictures``. Run this from the root of the checkout.
"""

import runpy
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
SCRIPTS = sorted([*HERE.glob("*.py"), *(HERE.parent / "figures").glob("*.py")])


def main(names: list[str]) -> None:
    """Run the scripts of these names, or all."""
    sys.path.insert(0, str(HERE))
    for script in SCRIPTS:
        if script.stem not in ("make", "field") and (not names or script.stem in names):
            sys.stdout.write(f"drawing {script.stem}\n")
            runpy.run_path(str(script))


if __name__ == "__main__":
    main(sys.argv[1:])
