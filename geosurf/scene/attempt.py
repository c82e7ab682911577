"""One picture at a time: an error of one costs no other result."""

from __future__ import annotations

from types import TracebackType

from geosurf.errors import GeosurfError


class Attempt:
    """Catches the error of one picture, whatever it is, so that all other results stay.

    Only exceptions that mean to end the program pass through.

    Examples
    --------
    >>> with Attempt() as tried:
    ...     1 / 0
    >>> tried.reason
    'ZeroDivisionError: division by zero. This is a fault of geosurf: please report it'
    """

    error: BaseException | None = None

    def __enter__(self) -> Attempt:
        """Begin."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> bool:
        """Keep the error."""
        # an Exception is swallowed and kept for `reason`; KeyboardInterrupt and SystemExit are
        # none, and pass
        self.error = error
        return isinstance(error, Exception)

    @property
    def reason(self) -> str:
        """What went wrong, as a part of a sentence; '' if nothing did."""
        # errors on purpose have a sentence for the user; anything else is a defect of geosurf
        if isinstance(self.error, GeosurfError | Warning):
            return str(self.error).rstrip(".")
        if isinstance(self.error, MemoryError):
            return "there is not enough memory for it"
        if self.error is None:
            return ""
        name = type(self.error).__name__
        return f"{name}: {self.error}. This is a fault of geosurf: please report it"
