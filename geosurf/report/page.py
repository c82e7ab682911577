"""Write tables and pictures as one self-contained HTML page."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from geosurf.conventions import counted
from geosurf.conventions.palette import hex_code
from geosurf.errors import InputError
from geosurf.model.protocols import Body, View3D

# ---- assets ----------------------------------------
# Style sheets, scripts and markup of pages, and the frame that refuses the network.
#
# =============  ====================================================================
# theme.css      colours, light and dark
# page.css       the report on the screen and on paper
# page.js        sorting and filtering of tables, pictures that enlarge
# viewer.css     the interactive view
# viewer.html    the markup of its controls
# viewer_*.js    parts of one script, see `viewer_script`
# =============  ====================================================================


@cache
def asset(name: str) -> str:
    """Return one of the files of the folder `assets` as text."""
    return (Path(__file__).with_name("assets") / name).read_text(encoding="utf-8")


def viewer_script() -> str:
    """Return the script of the interactive view: model, painter, controls."""
    parts = ("model", "painter", "controls")
    code = "\n".join(asset(f"viewer_{part}.js") for part in parts)
    return f'"use strict";\n(() => {{\n{code}}})();\n'


def document(title: str, body: str, styles: tuple[str, ...], scripts: tuple[str, ...]) -> str:
    """Return a page whose policy allows these styles and scripts, data in it, and no network.

    Parameters
    ----------
    title : str
        Is escaped.
    body : str
        HTML.
    styles, scripts : tuple of str

    Returns
    -------
    str
    """
    style = "\n".join(styles)
    policy = "; ".join(
        [
            "default-src 'none'",
            "img-src data:",
            f"style-src {_hash(style)}",
            f"script-src {' '.join(map(_hash, scripts))}",
            "base-uri 'none'",
            "form-action 'none'",
        ]
    )
    code = "\n".join(f"<script>{script}</script>" for script in scripts)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title>
<style>{style}</style>
</head>
<body>
{body}
{code}
</body>
</html>
"""


def _hash(text: str) -> str:
    """The hash by which a policy allows an inline style or script."""
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


# ---- table ----------------------------------------
# A table of text, and the format of its numbers; no HTML.


NOTHING = "–"  # an empty cell


@dataclass(frozen=True)
class Table:
    """Rows of text below a heading row.

    Attributes
    ----------
    head : tuple of str
        Headings of the columns.
    rows : tuple of tuple of str
    n_label : int
        Number of leading columns with text; the other columns have numbers.
    foot : tuple of str
        Last row with the sums; may be empty.
    n_remark : int
        Number of columns at the end with text.
    """

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    n_label: int = 1
    foot: tuple[str, ...] = ()
    n_remark: int = 0

    def holds_words(self, column: int) -> bool:
        """Whether a column has text, which is left-aligned and may wrap."""
        return column < self.n_label or column >= len(self.head) - self.n_remark


def number(value: float, decimals: int = 0) -> str:
    r"""Return a number with a true minus sign and thin spaces between thousands.

    Examples
    --------
    >>> number(-1234567.891, 1).replace("\N{NARROW NO-BREAK SPACE}", " ")
    '−1 234 567.9'
    """
    # + 0.0 turns -0.0 into 0.0: no minus sign before a zero
    text = f"{value + 0.0:,.{decimals}f}"
    return text.replace(",", "\N{NARROW NO-BREAK SPACE}").replace("-", "\N{MINUS SIGN}")


def as_plain_text(table: Table, corner: str) -> str:
    """Return a table as plain ASCII text in aligned columns, numbers to the right.

    Parameters
    ----------
    table : Table
        Table with one column of text.
    corner : str
        Heading of that column.

    Returns
    -------
    str

    Examples
    --------
    >>> print(as_plain_text(Table(("", "F1+", "F1-"), (("Top/Base", "8.5", NOTHING),)), "Zone"))
    Zone      F1+  F1-
    Top/Base  8.5    -
    """
    # consoles and pipes may lack these letters
    plain = str.maketrans({"\N{NARROW NO-BREAK SPACE}": " ", "\N{MINUS SIGN}": "-", NOTHING: "-"})

    # a table without sums has an empty foot
    body = [[cell.translate(plain) for cell in row] for row in (*table.rows, table.foot) if row]
    rows = [[corner, *table.head[1:]], *body]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for label, *numbers in rows:
        cells = [cell.rjust(w) for cell, w in zip(numbers, widths[1:], strict=True)]
        lines.append("  ".join([label.ljust(widths[0]), *cells]))
    return "\n".join(lines)


PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
PAPER = 84  # characters per printed line of A4 or Letter paper
LABEL, GAP = 26, 2  # characters for a column of text, which may wrap, and between columns


@dataclass(frozen=True)
class Section:
    """A heading of the page and the HTML below it; `parts` are the headings inside of it."""

    heading: str
    html: str
    parts: tuple[str, ...] = ()
    name: str = ""  # of the anchor; default: made from the heading


def fill_page(title: str, header: str, sections: Iterable[Section]) -> str:
    """Return the page: title, header, contents, and sections; empty sections are left out."""
    shown = [section for section in sections if section.html]
    anchors = Anchors()
    names = [anchors.name(section.name or section.heading) for section in shown]
    body = "\n".join(
        f'<section id="{name}">\n<h2>{escape(section.heading)}</h2>\n{section.html}\n</section>'
        for name, section in zip(names, shown, strict=True)
    )
    entries = "\n".join(
        f"<li>{_link(name, section.heading)}{_inner(section.parts)}</li>"
        for name, section in zip(names, shown, strict=True)
    )
    page = (
        f'<div class="page">\n<header>\n<h1>{escape(title)}</h1>\n{header}\n</header>\n'
        f'<nav class="contents" aria-label="Contents"><ul>\n{entries}\n</ul></nav>\n'
        f"<main>\n{body}\n</main>\n</div>"
    )
    styles = tuple(map(asset, ("theme.css", "viewer.css", "page.css")))
    return document(title, page, styles, (asset("page.js"), viewer_script()))


class Anchors:
    """Names of places of a page, each once.

    Examples
    --------
    >>> anchors = Anchors()
    >>> anchors.name("Volumes [million m³]"), anchors.name("Volumes"), anchors.name("<>")
    ('volumes-million-m', 'volumes', 'part')
    >>> anchors.name("volumes")
    'volumes-2'
    """

    def __init__(self) -> None:
        self.used: dict[str, int] = {}

    def name(self, words: str) -> str:
        """Return a name made from words."""
        slug = re.sub("[^a-z0-9]+", "-", words.lower()).strip("-") or "part"
        self.used[slug] = self.used.get(slug, 0) + 1
        return slug if self.used[slug] == 1 else f"{slug}-{self.used[slug]}"


def part_name(kind: str, row: int) -> str:
    """Return the anchor of a part of a section."""
    return f"{kind}-{row + 1}"


def _inner(parts: tuple[str, ...]) -> str:
    """Entries of the contents for the parts of a section."""
    links = (f"<li>{_link(part_name('fault', i), part)}</li>" for i, part in enumerate(parts))
    return f"<ul>{''.join(links)}</ul>" if parts else ""


def _link(name: str, words: str) -> str:
    return f'<a href="#{name}">{escape(words)}</a>'


def folded(summary: str, html: str) -> str:
    """Return HTML that opens with a click; it is printed open."""
    return f'<details class="fold"><summary>{escape(summary)}</summary>\n{html}\n</details>'


def paragraph(words: str, kind: str = "") -> str:
    """Return text as an HTML paragraph."""
    attribute = f' class="{kind}"' if kind else ""
    return f"<p{attribute}>{escape(words)}</p>"


def verdict(passed: bool, n_check: int) -> str:
    """Return the badge of a certificate: green if all checks passed, else red."""
    words = (
        f"Certificate: all {counted(n_check, 'check')} passed"
        if passed
        else "A check FAILED: see the certificate"
    )
    return badge(passed, words)


def badge(passed: bool, words: str) -> str:
    """Return a sentence as a badge, green or red; nothing for an empty one."""
    return f'<p class="verdict{"" if passed else " failed"}">{escape(words)}</p>' if words else ""


def html_table(table: Table) -> str:
    """Return a table as HTML, or an empty text for a table without rows.

    A table that is too wide for paper scrolls on the screen (`.screen`) and is printed in several
    parts (`.paper`), each with the columns of text.
    """
    if not table.rows:
        return ""
    whole = range(len(table.head))

    # a browser cannot break a table between columns, so wide ones are printed in parts
    parts = groups_of_columns(table)
    if len(parts) == 1:
        return f'<div class="wide">{_part(table, whole)}</div>'
    number = len(parts)
    printed = "\n".join(
        f"{paragraph(f'Table, part {k} of {number}', 'faint')}\n{_part(table, columns)}"
        for k, columns in enumerate(parts, 1)
    )
    screen = f'<div class="wide screen">{_part(table, whole)}</div>'
    return f'{screen}\n<div class="paper">\n{printed}\n</div>'


def groups_of_columns(table: Table) -> list[list[int]]:
    """Return the columns of each printed part: text columns in every part, numbers in turn.

    Examples
    --------
    >>> row = ("Top/Base", *("1 000.000",) * 20)
    >>> [len(part) for part in groups_of_columns(Table(("",) * 21, (row,)))]
    [7, 7, 7, 3]
    """
    # Text columns repeat in each part; numbers fill the room that they leave.
    # widths are in characters, not pixels: they need no browser, and the page stays the same on
    # every machine
    rows = [row for row in (*table.rows, table.foot) if row]
    words = [k for k in range(len(table.head)) if table.holds_words(k)]
    first = [k for k in words if k < table.n_label]
    room = PAPER - sum(min(max(len(row[k]) for row in rows), LABEL) + GAP for k in words)
    parts: list[list[int]] = [[]]
    used = 0

    # greedy fill from left to right: columns keep their order, and each part holds one column at
    # least, however wide that is
    for k in range(len(table.head)):
        if table.holds_words(k):
            continue

        # headings wrap on paper (`th` in the print style), so the longest word counts
        head = max(map(len, table.head[k].split()), default=0)
        wide = max(head, *(len(row[k]) for row in rows)) + GAP
        if parts[-1] and used + wide > room:
            parts.append([])
            used = 0
        parts[-1].append(k)
        used += wide
    last = [k for k in words if k >= table.n_label]
    return [[*first, *part, *last] for part in parts]


def _part(table: Table, columns: Iterable[int]) -> str:
    """Some columns of a table."""
    columns = list(columns)
    head = _row(table.head, table, columns, "th")
    rows = "\n".join(_row(row, table, columns) for row in table.rows)
    foot = f"\n<tfoot>{_row(table.foot, table, columns)}</tfoot>" if table.foot else ""
    return f"<table>\n<thead>{head}</thead>\n<tbody>\n{rows}\n</tbody>{foot}\n</table>"


def _row(cells: tuple[str, ...], table: Table, columns: list[int], tag: str = "td") -> str:
    out = []
    for column in columns:
        cell = cells[column]

        # colour follows the text of the first column, so `check_table` needs no HTML
        kinds = ["label"] if table.holds_words(column) else []
        if column == 0 and cell in ("passed", "FAILED"):
            kinds.append(cell.lower())
        attribute = f' class="{" ".join(kinds)}"' if kinds else ""
        out.append(f"<{tag}{attribute}>{escape(cell)}</{tag}>")
    return f"<tr>{''.join(out)}</tr>"


def html_pictures(pictures: Mapping[str, Path]) -> str:
    """Return pictures with their captions, embedded in the page.

    Raises
    ------
    InputError
        If a picture cannot be read or is not a PNG file.
    """
    figures = "\n".join(figure(caption, Path(path)) for caption, path in pictures.items())
    return f'<div class="pictures">\n{figures}\n</div>' if figures else ""


def figure(caption: str, path: Path) -> str:
    """Return one picture with its caption."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(
            f"picture {caption!r}: {path} cannot be read ({error.strerror}). "
            "Draw it before you write the report."
        ) from error

    # the signature alone is checked: enough to refuse a JPEG or a text file by mistake
    if not data.startswith(PNG_SIGNATURE):
        raise InputError(
            f"picture {caption!r}: {path} is not a PNG file. "
            "Pass a file that scene.plot.view wrote."
        )
    words = escape(caption)

    # inside the page as base64: a third larger than the file, but the page travels as one file
    source = base64.b64encode(data).decode("ascii")
    return (
        f'<figure><img alt="{words}" src="data:image/png;base64,{source}">'
        f"<figcaption>{words}</figcaption></figure>"
    )


# ---- viewer ----------------------------------------
# An interactive view in three dimensions: a part of the report, or a page of its own.
#
# Places are counted in 65 535 steps along each axis of the model, so a page needs six bytes for a
# point. Triangles of different surfaces share no points: that makes their edges sharp. Everything
# is written as little-endian base64; `assets/viewer_*.js` draws it, with WebGL 2 if the browser has
# it.


STEPS = 65_535
SHORT = 1 << 16  # points that two bytes can number


def viewer_html(view: View3D, title: str = "Model") -> str:
    """Return a self-contained HTML page with an interactive view; it needs no network.

    Parameters
    ----------
    view : View3D
        From `geosurf.render.interactive`.
    title : str

    Returns
    -------
    str
        The page. The same view gives the same text.

    Examples
    --------
    >>> import geosurf as gs
    >>> from geosurf.render.interactive import view_of_units
    >>> world = gs.synthetic.tilted_planes(n=3)
    >>> units = gs.Scene(world.horizons, world.faults, world.box).units
    >>> page = viewer_html(view_of_units(units), "Planes")
    >>> "<title>Planes</title>" in page and "src=" not in page
    True
    """
    styles, scripts = (asset("theme.css"), asset("viewer.css")), (viewer_script(),)
    return document(title, viewer_part(view), styles, scripts)


def viewer_part(view: View3D) -> str:
    """Return the view as a part of a page that has the style sheet and script of the viewer."""
    head, data = pack(view)

    # `<` may not appear in a script: it could end it
    words = json.dumps(head, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    code = base64.b64encode(data).decode("ascii")
    return Template(asset("viewer.html")).substitute(head=words, data=code)


def pack(view: View3D) -> tuple[dict[str, Any], bytes]:
    """Return what describes the bodies, and their arrays as bytes."""
    points = [body.points for body in view.bodies if len(body.points)]
    west, east, south, north, bottom, top = view.box
    corners = np.array([(west, south, bottom), (east, north, top)])
    low = np.min([corners[0], *(p.min(axis=0) for p in points)], axis=0)
    high = np.max([corners[1], *(p.max(axis=0) for p in points)], axis=0)

    # a model without height has steps of any size
    step = np.where(high > low, high - low, 1.0) / STEPS
    data = bytearray()
    bodies = [_packed(body, low, step, data) for body in view.bodies]
    head = {
        "lower": [_short(x) for x in low],
        "step": [float(x) for x in step],
        "box": [_short(x - low[i // 2]) for i, x in enumerate(view.box)],
        "exaggeration": view.exaggeration,
        "explode": view.explode,
        "bodies": bodies,
    }
    return head, bytes(data)


def _packed(body: Body, low: np.ndarray, step: np.ndarray, data: bytearray) -> dict[str, Any]:
    """Append the arrays of a body to `data`; return its description."""
    # one point for each surface and place: what a step does not tell apart is one point
    places = np.rint((body.points - low) / step).astype(np.int64)
    span = STEPS + 1
    code = (places[:, 0] * span + places[:, 1]) * span + places[:, 2]
    place = np.unique(code, return_inverse=True)[1].ravel()
    n = int(place.max(initial=0)) + 1
    keys = body.surface[:, None] * n + place[body.triangles]
    a, b, c = keys.T
    keys = keys[(a != b) & (b != c) & (c != a)]

    # lines take any of the points at their ends; a body of lines has no others
    ends = place[body.lines].reshape(-1, 2)
    ends = ends[ends[:, 0] != ends[:, 1]]
    bare = ends if not len(body.triangles) else ends[:0]
    used, rows = np.unique(np.concatenate([keys.ravel(), bare.ravel()]), return_inverse=True)
    triangles = rows.ravel()[: keys.size]
    here = np.zeros(n, dtype=np.int64)
    here[place] = np.arange(len(place))
    of_place = np.full(n, -1)
    of_place[used % n] = np.arange(len(used))
    lines = of_place[ends]
    lines = lines[(lines >= 0).all(axis=1)]
    places = places[here[used % n]]
    kind = "u2" if len(used) <= SHORT else "u4"
    arrays = {"points": (places, "u2"), "triangles": (triangles, kind), "lines": (lines, kind)}
    return {
        "name": body.name,
        "group": body.group,
        "colour": hex_code(body.colour),
        "facts": body.facts,
        "shift": [_short(x) for x in body.shift],
        "closed": body.closed,
        "on": body.shown,
        **{name: _append(array, kind, data) for name, (array, kind) in arrays.items()},
    }


def _append(array: np.ndarray, kind: str, data: bytearray) -> tuple[str, int, int]:
    """Append an array at a multiple of four bytes; return its kind, offset and length."""
    data.extend(bytes(-len(data) % 4))
    offset = len(data)
    data.extend(np.ascontiguousarray(array, dtype=f"<{kind}").tobytes())
    return kind, offset, int(array.size)


def _short(value: float) -> float:
    """Millimetres are enough."""
    return round(float(value), 3)
