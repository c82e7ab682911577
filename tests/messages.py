"""One check of what is refused: the class of the error, its words, and the form of its sentence."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from geosurf.errors import GeosurfError


def refused(
    error: type[Exception], words: str, call: Callable[..., Any], *given: Any, **options: Any
) -> Exception:
    """Call, and hand back the error of this class in whose message a pattern occurs.

    An error of geosurf is plain sentences on one line: what is wrong, where, what to do.
    """
    with pytest.raises(error, match=words) as caught:
        call(*given, **options)
    said = str(caught.value)
    if isinstance(caught.value, GeosurfError):
        assert said.isprintable(), said
        assert said.endswith((".", "?", '"')), said  # or with what to type
    return caught.value
