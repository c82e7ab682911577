"""A table of text, and the format of its numbers; no HTML."""

from __future__ import annotations

from dataclasses import dataclass

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
