"""What geosurf answers to mistakes at the command line and in scenarios, as a page.

``python -m tests.cli.mistakes > docs/validation/mistakes.md`` writes the page. With a folder of
another checkout behind it, the page shows the messages of that checkout, too.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.cli.test_arguments import MISTAKES as AT_THE_CONSOLE
from tests.scenario.test_mistakes import BROKEN, MISTAKES, MORE, RIGHT

COUNT = re.compile(r"\d+ mistakes?\.")
HEAD = """# Mistakes and their messages

What geosurf prints for {n_console} mistakes at the command line and {n_scenario} in a scenario.
Each ends with exit code 2. Tests compare every message, and the line of a scenario that it names
(`tests/cli/test_arguments.py`, `tests/scenario/test_mistakes.py`).

**Command.** `python -m tests.cli.mistakes{arguments}`

**When.** November 2026.
"""


def answer(code: Path, folder: Path, words: str) -> str:
    """Run one command with the code of a checkout, and return all that it prints."""
    done = subprocess.run(
        f"{sys.executable} -m geosurf.cli {words}",
        shell=True, cwd=folder, capture_output=True, text=True, check=False,
        env={"PYTHONPATH": str(code), "PATH": "/usr/bin:/bin", "HOME": str(folder)},
    )  # fmt: skip
    lines = (done.stdout + done.stderr).strip().splitlines()
    text = " ".join(line.strip() for line in lines if not COUNT.fullmatch(line.strip()))
    return text.replace(f"{folder}/", "").replace("|", "\\|")


def rows(codes: list[Path]) -> tuple[list[list[str]], list[list[str]]]:
    """Each mistake with its answers: at the command line, and in a scenario."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        console = [
            [
                f"`geosurf {words}`".replace("|", "\\|"),
                *(answer(code, folder, words) for code in codes),
            ]
            for words in AT_THE_CONSOLE
        ]
        scenario = []
        for row, line, _ in MISTAKES + MORE + BROKEN:
            lines = RIGHT.splitlines()
            lines[row - 1] = line
            (folder / "scenario.toml").write_text("\n".join(lines) + "\n")
            found = (answer(code, folder, "validate scenario.toml") for code in codes)
            scenario.append([f"`{line}`", *found])
    return console, scenario


def table(head: list[str], body: list[list[str]]) -> str:
    """A table of Markdown."""
    lines = [head, ["---"] * len(head), *body]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def page(before: Path | None) -> str:
    """Return the page."""
    today = Path(__file__).resolve().parents[2]
    codes = [today] if before is None else [before, today]
    console, scenario = rows(codes)
    head = ["message"] if before is None else ["before", "message"]
    text = HEAD.format(
        n_console=len(console),
        n_scenario=len(scenario),
        arguments="" if before is None else " CHECKOUT",
    )
    return "\n".join(
        [
            text,
            "## At the command line\n",
            table(["typed", *head], console),
            "## In a scenario, by `geosurf validate`\n",
            table(["line", *head], scenario),
        ]
    )


if __name__ == "__main__":
    sys.stdout.write(page(Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else None))
