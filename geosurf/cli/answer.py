"""What a command has found: text for people, data for scripts, and the exit code."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Answer:
    """
    The result of a command.

    Attributes
    ----------
    data : object
        What ``--json`` prints: dicts, lists, text, numbers; paths become text.
    text : str
        What is printed without ``--json``.
    code : int
        The exit code.
    closing : tuple of str
        Sentences on what to open and what to check; ``--json`` leaves them out.
    """

    data: Any
    text: str = ""
    code: int = 0
    closing: tuple[str, ...] = ()

    def shown(self, *, as_json: bool, quiet: bool) -> str:
        r"""
        Return what is printed on stdout.

        Examples
        --------
        >>> answer = Answer({"volume_m3": float("nan")}, "1 unit", closing=("Report: index.html",))
        >>> answer.shown(as_json=True, quiet=True)
        '{\n  "volume_m3": null\n}'
        >>> answer.shown(as_json=False, quiet=False)
        '1 unit\nReport: index.html'
        >>> answer.shown(as_json=False, quiet=True)
        ''
        """
        if as_json:
            return json.dumps(plain(self.data), indent=2)
        return "" if quiet else "\n".join(filter(None, (self.text, *self.closing)))


def plain(value: Any) -> Any:
    """
    Return a value as JSON holds it: numbers that are not finite become null.

    Examples
    --------
    >>> import pathlib
    >>> plain({"path": pathlib.PurePosixPath("out"), "of": (1, float("inf"))})
    {'path': 'out', 'of': [1, None]}
    """
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    # numpy's numbers and arrays know what they are in Python; everything else is text
    return plain(value.tolist()) if hasattr(value, "tolist") else str(value)


__all__ = ["Answer", "plain"]
