"""How objects show themselves in notebooks: a title and a table, in light and dark."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from geosurf.conventions.palette import RGB, fault, hex_code

# ---- card map ----------------------------------------
# A small map for the card of an object, as SVG: an outline, and named lines in it.


SIZE, MARGIN = 220.0, 8.0  # of the longer side [pixels]


def small_map(
    outline: np.ndarray,
    lines: Mapping[str, Sequence[np.ndarray]],
    places: Mapping[str, Sequence[float]] | None = None,
) -> str:
    """
    Return a map as SVG, north up; names show when the mouse is over their lines.

    Parameters
    ----------
    outline : ndarray of float64, shape (n, 2)
        Easting and northing of the corners of the area [m].
    lines : mapping of str to sequence of ndarray of float64, each (n, 2)
        By name, in the colours of faults.
    places : mapping of str to (float, float), optional
        Points [m] by the words next to them.

    Returns
    -------
    str

    Examples
    --------
    >>> square = np.array([[0.0, 0], [100, 0], [100, 50], [0, 50]])
    >>> text = small_map(square, {"<F1>": [np.array([[10.0, 10], [90, 40]])]})
    >>> "<title>&lt;F1&gt;</title>" in text, 'viewBox="0 0 236 126"' in text
    (True, True)
    """
    marked = np.array(list((places or {}).values()), dtype=float).reshape(-1, 2)
    drawn_lines = (part for parts in lines.values() for part in parts)
    every = np.concatenate([outline, marked, *drawn_lines])
    low, high = every.min(axis=0), every.max(axis=0)
    scale = SIZE / max(float((high - low).max()), np.finfo(float).tiny)

    def path(points: np.ndarray) -> str:
        """Pixels from the upper left, to a tenth."""
        x = (points[:, 0] - low[0]) * scale + MARGIN
        y = (high[1] - points[:, 1]) * scale + MARGIN
        return "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y, strict=True))

    width, height = (f"{side:.0f}" for side in (high - low) * scale + 2.0 * MARGIN)
    marks = [f'<path d="{path(outline)}Z" fill="none" stroke="currentColor" opacity=".5"/>']
    for number, (name, parts) in enumerate(lines.items()):
        drawn = " ".join(path(part) for part in parts if len(part) > 1)
        marks.append(
            f'<path d="{drawn}" fill="none" stroke="{hex_code(fault(number))}" stroke-width="2.5">'
            f"<title>{escape(name)}</title></path>"
        )
    for words, point in (places or {}).items():
        x, y = path(np.array([point], dtype=float))[1:].split()
        # words at the right rim go to the left of their point
        right = float(x) + 7.0 * len(words) + 5.0 > float(width)
        side = 'dx="-5" text-anchor="end"' if right else 'dx="5"'
        marks.append(
            f'<circle cx="{x}" cy="{y}" r="3" fill="currentColor"/><text x="{x}" y="{y}" {side} '
            f'dy="-3" font-size="11" fill="currentColor">{escape(words)}</text>'
        )
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" '
        f'aria-label="map, north up">{"".join(marks)}</svg>'
    )


MOST = 30  # rows; a model may have thousands of units
CELL = "padding:1px 8px;border:0;font-variant-numeric:tabular-nums"
SWATCH = "display:inline-block;width:.8em;height:.8em;margin-right:.5em;vertical-align:-1px"


@dataclass(frozen=True)
class Card:
    """
    What a notebook shows of an object.

    Attributes
    ----------
    title : str
    rows : sequence of sequence of str
        Cells, not escaped yet; numbers end with their unit.
    head : sequence of str
        Names of the columns; empty if the first column names the rows.
    colours : sequence of (float, float, float)
        One for each row, or none.
    notes : sequence of str
        Sentences below the table.
    n_row : int
        How many rows there are, where `rows` has the first ones only.
    picture : str
        SVG below the title, as `geosurf.conventions.card` makes it.
    """

    title: str
    rows: Sequence[Sequence[str]] = ()
    head: Sequence[str] = ()
    colours: Sequence[RGB] = ()
    notes: Sequence[str] = ()
    n_row: int = 0
    picture: str = ""

    def html(self) -> str:
        """
        Return the card as HTML: colours of text and lines are those of the page.

        Examples
        --------
        >>> text = Card("<Top>", [("vertices", "25")]).html()
        >>> "&lt;Top&gt;" in text and "vertices" in text
        True
        """
        lines = [f"<div><strong>{escape(self.title)}</strong>"]
        if self.picture:
            lines.append(f"<div>{self.picture}</div>")
        if self.rows:
            lines.append('<table style="margin:.3em 0;border-collapse:collapse">')
            if self.head:
                cells = "".join(self._cell("th", word, k) for k, word in enumerate(self.head))
                lines.append(f"<tr>{cells}</tr>")
            for n, row in enumerate(self.rows[:MOST]):
                swatch = _swatch(self.colours[n]) if self.colours else ""
                cells = "".join(
                    self._cell("td", word, k, swatch if k == 0 else "")
                    for k, word in enumerate(row)
                )
                lines.append(f"<tr>{cells}</tr>")
            lines.append("</table>")
        notes = list(self.notes)
        left = max(self.n_row, len(self.rows)) - MOST
        if left > 0:
            notes.insert(0, f"and {left} more")
        lines += [f'<div style="margin:.3em 0">{escape(note)}</div>' for note in notes]
        return "\n".join([*lines, "</div>"])

    def _cell(self, tag: str, word: str, column: int, before: str = "") -> str:
        """One cell; numbers in the last column of a table with a head are on the right."""
        last = bool(self.head) and column == len(self.head) - 1
        right = last and self.rows[0][-1][:1].isdigit()
        style = f"{CELL};text-align:{'right' if right else 'left'}"
        return f'<{tag} style="{style}">{before}{escape(word)}</{tag}>'


def _swatch(colour: RGB) -> str:
    return f'<span style="{SWATCH};background:{hex_code(colour)}"></span>'
