"""The page docs/scenario.md, made from the dataclasses."""

from __future__ import annotations

import inspect
import re
import sys
from dataclasses import MISSING, Field, fields
from typing import Any

from geosurf.scenario.keys import Scenario

HEAD = """# Scenario files

A scenario is a TOML file that names the inputs of a model and what is wanted of it. Run it with
`geosurf run scenario.toml -o out/` or `geosurf.run_scenario("scenario.toml", "out/")`.

Paths are relative to the folder of the scenario. Keys that are not listed here are errors, so that
a typing error is not overlooked. The smallest scenario has one horizon:

```toml
[[horizons]]
name = "Top"
file = "top.gri"
positive = "down" # the file holds depths
```

A larger one, which `make demo` runs:
[faulted_reservoir.toml](../data/synthetic_horizons/faulted_reservoir.toml).

What a run writes into the output folder: `units.vtm` with the folder `units/`, `curves.vtp`,
`volumes.csv`, `volumes.nc`, `certificate.txt`, `pictures/*.png` and `report/index.html`. All of it
appears when the last file is ready, and replaces what an earlier run left there; files under other
names are not touched. A run that is stopped leaves the old results or the new ones. At the end
files move in one by one: old ones go first, and `UNFINISHED.txt` is there meanwhile. The next run
finishes what a killed one has left. One run at a time writes into a folder. Where the geometry is
impossible at one place, `failure.png` shows it:
for a horizon that cannot be torn, the hole, both walls, the faults and the data there.

This page is made from the code by `python docs/scenario_page.py > docs/scenario.md`.
"""


def scenario_page() -> str:
    """Return the page: one table of keys per table of a scenario.

    Returns
    -------
    str
        Markdown.
    """
    # keys at the top of the file, then one section for each table
    # fields that are tables themselves have the dataclass of their keys as `kind`
    tables = {entry.name: _kind(entry) for entry in fields(Scenario) if _kind(entry)}
    plain = [entry for entry in fields(Scenario) if _is_key(entry) and entry.name not in tables]
    parts = [HEAD, _section("Top level", "", plain, Scenario)]
    for name, kind in tables.items():
        parts += _table(name, kind, Scenario)
    return "\n".join(parts)


def _table(name: str, kind: Any, inside: Any) -> list[str]:
    """The section of one table, and those of the tables in it."""
    # the docstring after its first colon: what stands before it is the name of the table
    text = " ".join(_doc(kind)[0].split()).partition(": ")[2]
    word = name.rpartition(".")[2]
    entry = next(one for one in fields(inside) if one.name == word)
    brackets = f"[[{name}]]" if "tuple" in str(entry.type) else f"[{name}]"
    own = [one for one in fields(kind) if _is_key(one) and not _kind(one)]
    parts = [_section(f"`{brackets}`", text[:1].upper() + text[1:], own, kind)]
    for one in fields(kind):
        if _is_key(one) and _kind(one):
            parts += _table(f"{name}.{one.name}", _kind(one), kind)
    return parts


def _is_key(entry: Field[Any]) -> bool:
    return "check" in entry.metadata


def _kind(entry: Field[Any]) -> Any:
    """The dataclass behind a key that is a table."""
    return getattr(entry.metadata.get("check"), "kind", None)


def _doc(kind: Any) -> tuple[str, dict[str, str]]:
    """The docstring of a table: its first paragraph, and the meaning of each key."""
    first, _, attributes = (inspect.getdoc(kind) or "").partition("\n\nAttributes\n----------\n")
    blocks = re.findall(r"^(\w+).*\n((?: +.*(?:\n|\Z))+)", attributes, re.MULTILINE)
    return first, {name: " ".join(text.split()) for name, text in blocks}


def _section(title: str, text: str, entries: list[Field[Any]], kind: Any) -> str:
    meanings = _doc(kind)[1]
    rows = [
        f"| `{e.name}` | {e.metadata['unit'] or '–'} | {_default(e)} | {meanings[e.name]} "
        f"Value: {_code(e.metadata['check'].allowed)}. |"
        for e in entries
    ]
    head = ["| key | unit | default | meaning |", "|---|---|---|---|"]
    return "\n".join([f"## {title}", "", *([text, ""] if text else []), *head, *rows, ""])


def _default(entry: Field[Any]) -> str:
    value = entry.default
    # Defaults as they are typed in TOML.
    if value is MISSING:
        return "required"
    if value is None:
        return "left out"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, tuple):
        return f"`{list(value)}`".replace("'", '"')
    return f'`"{value}"`' if isinstance(value, str) else f"`{value}`"


def _code(allowed: str) -> str:
    """Words between quotes as code: as they are typed."""
    return allowed.replace("'", "`").replace("[", "`[").replace("]", "]`")


if __name__ == "__main__":
    sys.stdout.write(scenario_page())
