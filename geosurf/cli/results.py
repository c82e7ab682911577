"""What commands print in common: progress, and the verdict of a certificate."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.model import Certificate


CHECK_FAILED = 3  # exit code


def progress_printer(quiet: bool) -> Callable[[str], object] | None:
    """Return a function that prints a line of progress, or None for a quiet command."""
    return None if quiet else lambda line: print(line, flush=True)


def exit_code_of(certificate: Certificate) -> int:
    """Return the exit code of a certificate; print the checks that failed."""
    # the code of geometry: the model was built, and the check says that it must not be used
    failed = [f"{check.name} ({check.detail})" for check in certificate.checks if not check.passed]
    if not failed:
        return 0
    print(
        f"geosurf: the model fails its check: {'; '.join(failed)}. Inspect these places "
        "before you use the model.",
        file=sys.stderr,
    )
    return CHECK_FAILED
