"""Write tables and pictures as one self-contained HTML page."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path
from string import Template

from geosurf.conventions import counted
from geosurf.errors import InputError
from geosurf.report.table import Table

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
PAPER = 84  # characters per printed line of A4 or Letter paper
LABEL, GAP = 26, 2  # characters for a column of text, which may wrap, and between columns

# tables appear twice in the source if they are too wide for paper: `.screen` scrolls sideways,
# `.paper` repeats the text columns in each part
PAGE = Template(
    """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<style>
:root { --ink: #26292e; --faint: #6b7280; --rule: #d8dbe0; --wash: #f6f4ee;
  --red: #a51d1d; --green: #2f6b3c; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2.5rem 1.5rem 4rem; max-width: 68rem; color: var(--ink);
  font: 15px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
h1 { margin: 0 0 .2rem; font-size: 1.9rem; letter-spacing: -.01em; }
h2 { margin: 2.6rem 0 .7rem; padding-bottom: .3rem; border-bottom: 2px solid var(--ink);
  font-size: 1.2rem; }
p { margin: .4rem 0; max-width: 46rem; }
.faint, figcaption { color: var(--faint); }
.verdict { display: inline-block; margin-top: .8rem; padding: .35rem .9rem; border-radius: .3rem;
  font-weight: 600; color: white; background: var(--green); }
.verdict.failed { background: var(--red); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: .4rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .32rem .9rem .32rem 0; text-align: right; vertical-align: top;
  white-space: nowrap;  border-bottom: 1px solid var(--rule); }
th { font-weight: 600; font-size: .87em; color: var(--faint); }
.label { text-align: left; white-space: normal; overflow-wrap: anywhere; min-width: 6em; }
.paper { display: none; }
tfoot td { font-weight: 600; border-top: 1.5px solid var(--ink); border-bottom: 0; }
td.failed { color: var(--red); font-weight: 700; }
td.passed { color: var(--green); }
figure { margin: 1rem 0 1.8rem; }
img { display: block; width: 100%; border: 1px solid var(--rule); }
figcaption { margin-top: .35rem; font-size: .93em; }
pre { padding: .8rem 1rem; background: var(--wash); overflow-x: auto; font-size: .87em;
  line-height: 1.4; }
@media print {
  @page { margin: 15mm; }
  body { padding: 0; max-width: none; font-size: 10pt; }
  .screen { display: none; }
  .paper { display: block; }
  .wide { overflow: visible; }
  th { white-space: normal; }
  pre { white-space: pre-wrap; overflow: visible; overflow-wrap: anywhere; }
  figure, tr { break-inside: avoid; }
  thead { display: table-header-group; }
  tfoot { display: table-row-group; }
  h2 { break-after: avoid; }
  .verdict { color: var(--ink); background: none; border: 1.5px solid var(--ink); }
}
</style>
</head>
<body>
<header>
<h1>$title</h1>
$header
</header>
$sections
</body>
</html>
"""
)


def fill_page(title: str, header: str, sections: list[tuple[str, str]]) -> str:
    """Return the page: a title, the header below it, and sections of HTML with headings."""
    body = "\n".join(
        f"<section>\n<h2>{escape(head)}</h2>\n{html}\n</section>" for head, html in sections if html
    )
    return PAGE.substitute(title=escape(title), header=header, sections=body)


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
    return f'<p class="verdict{"" if passed else " failed"}">{words}</p>'


def html_table(table: Table) -> str:
    """Return a table as HTML, or an empty text for a table without rows.

    A table that is too wide for paper scrolls on the screen and is printed in several parts.
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
    return "\n".join(_figure(caption, Path(path)) for caption, path in pictures.items())


def _figure(caption: str, path: Path) -> str:
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
            f"picture {caption!r}: {path} is not a PNG file. Pass a file that render_scene wrote."
        )
    words = escape(caption)

    # inside the page as base64: a third larger than the file, but the page travels as one file
    source = base64.b64encode(data).decode("ascii")
    return (
        f'<figure><img alt="{words}" src="data:image/png;base64,{source}">'
        f"<figcaption>{words}</figcaption></figure>"
    )
