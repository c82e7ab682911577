"""Where each key of a TOML file is: `tomllib` gives values without their lines.

The text has been read by `tomllib` before, so it is valid: the scan only has to find keys, and to
skip values without mistaking their content for keys.
"""

from __future__ import annotations

import re
import tomllib

Keys = tuple[str | int, ...]

# Multi-line strings may end with quotes of their own before the closing three.
_TOKEN = re.compile(
    r'''(?P<skip>[ \t\r]+|\#[^\n]*)
    |(?P<text>"""(?:[^\\]|\\.)*?"""(?!")|\'\'\'.*?\'\'\'(?!\')|"(?:[^"\\\n]|\\.)*"|'[^'\n]*')
    |(?P<mark>[\[\]{}=,.\n])
    |(?P<bare>[^\s\[\]{}=,."'\#]+)''',
    re.DOTALL | re.VERBOSE,
)


def lines_of_keys(text: str) -> dict[Keys, int]:
    r"""
    Return the line of each table and key, counted from 1.

    Parameters
    ----------
    text : str
        Valid TOML, with lines that end with a line feed.

    Returns
    -------
    dict of tuple to int
        By the path of keys; tables in double brackets and entries of arrays are counted from 0.

    Examples
    --------
    >>> found = lines_of_keys('title = "a"\n[[horizons]]\nname = "Top"\n')
    >>> found["horizons", 0], found["horizons", 0, "name"]
    (2, 3)
    """
    scan = _Scan(text)
    table: Keys = ()
    while scan.token:
        if scan.token == "\n":
            scan.step()
        elif scan.token == "[":
            table = scan.header()
        else:
            scan.key_and_value(table)
    return scan.lines


class _Scan:
    """Goes through the tokens of a text, and notes where keys are."""

    def __init__(self, text: str) -> None:
        self.lines: dict[Keys, int] = {}
        self._n_tables: dict[Keys, int] = {}  # tables of each list in double brackets
        self._tokens = _TOKEN.finditer(text)
        self._line, self._n_line_ends = 1, 0
        self.token = ""
        self.step()

    def step(self) -> str:
        """Go to the next token, and return the one before; '' is the end."""
        before = self.token
        self._line += self._n_line_ends
        for found in self._tokens:
            if found.lastgroup != "skip":
                self.token, self._n_line_ends = found.group(), found.group().count("\n")
                return before
        self.token, self._n_line_ends = "", 0
        return before

    def header(self) -> Keys:
        """Read ``[table]`` or ``[[table]]``, and return its path."""
        line = self._line
        self.step()
        double = self.token == "["
        if double:
            self.step()
        path = self._inside((), self._dotted("]"), line, counted=double)
        for _ in range(1 + double):
            self.step()
        return path

    def _inside(self, path: Keys, words: list[str], line: int, *, counted: bool = False) -> Keys:
        """The path of a table; a name of a list in double brackets stands for its last table."""
        for k, word in enumerate(words):
            path = (*path, word)
            if counted and k == len(words) - 1:
                self._n_tables[path] = self._n_tables.get(path, 0) + 1
            self.lines.setdefault(path, line)
            if path in self._n_tables:
                path = (*path, self._n_tables[path] - 1)
                self.lines.setdefault(path, line)
        # a table may be opened after a table inside it
        if not counted:
            self.lines[path] = line
        return path

    def _dotted(self, end: str) -> list[str]:
        """Read the words of a key up to a mark, which stays."""
        words = []
        while self.token != end:
            token = self.step()
            if token[0] in "\"'":
                words.append(tomllib.loads(f"key = {token}")["key"])
            elif token != ".":
                words.append(token)
        return words

    def key_and_value(self, table: Keys) -> None:
        """Read ``key = value``."""
        line = self._line
        words = self._dotted("=")
        self.step()
        path = table
        for word in words:
            path = (*path, word)
            self.lines.setdefault(path, line)
        self._value(path)

    def _value(self, path: Keys) -> None:
        """Read a value: an array, a table in braces, or anything up to its end."""
        if self.token == "{":
            self.step()
            while self.token != "}":
                if self.token in (",", "\n"):
                    self.step()
                else:
                    self.key_and_value(path)
            self.step()
        elif self.token == "[":
            self.step()
            row = 0
            while self.token != "]":
                if self.token in (",", "\n"):
                    self.step()
                else:
                    self.lines[*path, row] = self._line
                    self._value((*path, row))
                    row += 1
            self.step()
        else:
            # numbers and dates may consist of several tokens
            while self.token and self.token not in (",", "]", "}", "\n"):
                self.step()


__all__ = ["Keys", "lines_of_keys"]
