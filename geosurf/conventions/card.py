"""How objects show themselves in notebooks: a title and a table, in light and dark."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from geosurf.conventions.colours import RGB

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
        SVG below the title, as `geosurf.conventions.card_map` makes it.
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
    code = "".join(f"{round(255 * part):02x}" for part in colour)
    return f'<span style="{SWATCH};background:#{code}"></span>'


__all__ = ["MOST", "Card"]
