"""What ``mypy --strict`` finds in each room: ``python -m benchmarks.types`` (half a minute).

The table of docs/validation/types.md. The overrides of pyproject.toml, which make the profiles, are
left out, so that all rooms are counted by one measure.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ANY_RESULT = "no-any-return"
LACKS_TYPES = ("no-untyped-def", "no-untyped-call")


def errors_of_rooms() -> dict[str, Counter[str]]:
    """Return how often each kind of error occurs in each room, with no override."""
    settings = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    settings = re.sub(r"(?s)\[\[tool\.mypy\.overrides\]\].*?(?=\n\[|\Z)", "", settings)
    settings = settings.replace("warn_return_any = false", "warn_return_any = true")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "pyproject.toml"
        file.write_text(settings, encoding="utf-8")
        command = [sys.executable, "-m", "mypy", "--config-file", str(file)]
        found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)

    rooms: dict[str, Counter[str]] = {}
    for path, kind in re.findall(
        r"^geosurf/([^:]+):\d+: error: .*\[([\w-]+)\]$", found.stdout, re.MULTILINE
    ):
        rooms.setdefault(path.partition("/")[0].removesuffix(".py"), Counter())[kind] += 1
    return rooms


def main() -> None:
    """Print the table, without the column of profiles."""
    rooms = errors_of_rooms()
    print("| room | files | functions or calls without types | results of type Any | other |")
    print("|---|---|---|---|---|")
    for path in sorted((ROOT / "geosurf").iterdir()):
        n_file = len(list(path.rglob("*.py"))) if path.is_dir() else 1
        if n_file and path.suffix in ("", ".py") and path.name != "__pycache__":
            found = rooms.get(path.stem, Counter())
            untyped = sum(found[kind] for kind in LACKS_TYPES)
            other = found.total() - untyped - found[ANY_RESULT]
            print(f"| `{path.stem}` | {n_file} | {untyped} | {found[ANY_RESULT]} | {other} |")


if __name__ == "__main__":
    main()
