"""The lines of a certificate."""

from __future__ import annotations

from dataclasses import dataclass

from geosurf.conventions.card import Card


@dataclass(frozen=True)
class Check:
    """One line of a certificate."""

    name: str
    passed: bool
    value: float
    detail: str


@dataclass(frozen=True, repr=False)
class Certificate:
    """What `Scene.check` found, line by line.

    Attributes
    ----------
    checks : tuple of Check
    """

    checks: tuple[Check, ...]

    @property
    def ok(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    def _repr_html_(self) -> str:
        """Return the lines as a table."""
        rows = [("pass" if c.passed else "FAIL", c.name, c.detail) for c in self.checks]
        title = "Certificate: every check passed" if self.ok else "Certificate: the model FAILS"
        return Card(title, rows).html()

    def __repr__(self) -> str:
        # Details start in one column.
        width = max((len(check.name) for check in self.checks), default=0)
        return "\n".join(
            f"{'pass' if c.passed else 'FAIL'}  {c.name:<{width}}  {c.detail}" for c in self.checks
        )
