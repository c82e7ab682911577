"""Names on pictures: shortened without becoming alike, and placed without lying over each other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import takewhile

import numpy as np

from geosurf.render.layers import LABEL_ROOM

CUT = "…"
HEAD = 5  # letters of the start of a label whose end is left out
MARGIN = 1.5  # around names [pixels]
LEAST = 9  # letters of a label that can be told apart
NAME_SIZE = 12.0  # of names at points [design pixels]


def shortened(words: str, most: int = LABEL_ROOM) -> str:
    """Return text of at most so many letters; both the start and the end of a name remain.

    Examples
    --------
    >>> shortened("a horizon with a very long name")
    'a horizon…long name'
    >>> shortened("UpperVolantis/LowerVolantis")
    'Upper…ntis/Lower…ntis'
    """
    if len(words) <= most:
        return words

    # zones are named by two horizons: each of them is shortened by itself
    parts = words.split("/")
    if len(parts) == 2 and min(map(len, parts)) > most // 2:
        return "/".join(shortened(part, most // 2) for part in parts)
    return f"{words[: most // 2].rstrip()}{CUT}{words[-(most // 2 - 1) :].lstrip()}"


def shortened_apart(names: Iterable[str], most: int = LABEL_ROOM) -> dict[str, str]:
    """Return a label of at most so many letters for each name; different names stay different.

    Parameters
    ----------
    names : iterable of str
    most : int
        At least `LEAST`.

    Returns
    -------
    dict of str to str

    Examples
    --------
    >>> names = [f"Lower sandstone, member {i} (northern part)" for i in (12, 13)]
    >>> list(shortened_apart(names).values())
    ['Lower…12', 'Lower…13']
    """
    names = list(dict.fromkeys(names))
    found = {name: shortened(name, most) for name in names}

    # zones are named by two horizons: each of them has to be told apart
    zones = [name for name in names if len(name) > most and name.count("/") == 1]
    if zones and most > 2 * LEAST:
        parts = [part for name in zones for part in name.split("/")]
        labels = shortened_apart(parts, (most - 1) // 2)
        found |= {name: "/".join(labels[part] for part in name.split("/")) for name in zones}
    for group in _alike(found):
        found |= _with_difference(group, most)

    # names that differ in more than fits are numbered
    for group in _alike(found):
        for i, name in enumerate(group, start=1):
            number = f"{CUT}({i})"
            found[name] = f"{name[: most - len(number)].rstrip()}{number}"
    return found


def _alike(labels: dict[str, str]) -> list[list[str]]:
    """Groups of names that have the same label."""
    groups: dict[str, list[str]] = {}
    for name, label in labels.items():
        groups.setdefault(label, []).append(name)
    return [group for group in groups.values() if len(group) > 1]


def _with_difference(names: Sequence[str], most: int) -> dict[str, str]:
    """Labels that keep the first difference of names of equal starts."""
    start = _alike_at_start(names)
    end = _alike_at_start([name[start:][::-1] for name in names])

    # whole numbers: "12" and "13" do not become "2" and "3"
    while start and names[0][start - 1].isdigit():
        start -= 1
    while end and names[0][len(names[0]) - end].isdigit():
        end -= 1
    found = {}
    for name in names:
        middle = name[start : len(name) - end]
        tail = name[len(name) - end :]

        # the difference first, then as much of the end as fits, then of the start
        room = most - 1 - len(middle)
        if room < 4:
            middle, tail = middle[: most - 5], ""
            room = most - 1 - len(middle)
        head = name[: most - 1 - len(middle) - len(tail)]
        if len(tail) > room - 3:
            # an end that does not fit is left out, and the label stays short
            tail, head = "", name[: min(room, HEAD)]
        found[name] = f"{head.rstrip()}{CUT}{middle}{tail}"
    return found


def _alike_at_start(names: Sequence[str]) -> int:
    """How many letters all names have in common at the start."""
    columns = zip(*names, strict=False)
    return sum(1 for _ in takewhile(lambda letters: len(set(letters)) == 1, columns))


class Room:
    """The parts of a picture that names have taken: boxes (left, bottom, right, top) [pixels]."""

    def __init__(self, taken: Iterable[Sequence[float]] = ()) -> None:
        self.taken = [np.asarray(box, dtype=np.float64) for box in taken]

    def take(self, box: Sequence[float]) -> bool:
        """Take a box if it is free, with a margin for rims; return whether it was."""
        left, bottom, right, top = (
            box[0] - MARGIN, box[1] - MARGIN, box[2] + MARGIN, box[3] + MARGIN,
        )  # fmt: skip
        for one in self.taken:
            if left < one[2] and one[0] < right and bottom < one[3] and one[1] < top:
                return False
        self.taken.append(np.array([left, bottom, right, top]))
        return True
