"""What commands answer in common: units, warnings, and the verdict of a certificate."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.errors import GeosurfWarning
    from geosurf.model import Certificate, Units


CHECK_FAILED = 3  # exit code


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


def units_data(units: Units) -> list[dict[str, Any]]:
    """Return one dict per unit, with the columns of the table of volumes."""
    table = units._plain_table
    columns = {"unit": table.coords["unit"], **table.data_vars, **table.coords}
    values = (column.values.tolist() for column in columns.values())
    return [dict(zip(columns, row, strict=True)) for row in zip(*values, strict=True)]


def warnings_data(warnings: Iterable[GeosurfWarning]) -> list[dict[str, Any]]:
    """Return one dict per warning."""
    return [
        {
            "kind": one.kind,
            "subject": one.subject,
            "effect": one.effect,
            "remedy": one.remedy,
            "place": one.place,
        }
        for one in warnings
    ]


def certificate_data(certificate: Certificate) -> dict[str, Any]:
    """Return the lines of a certificate and whether all of them passed."""
    lines = [
        {"name": one.name, "passed": one.passed, "value": one.value, "detail": one.detail}
        for one in certificate.checks
    ]
    return {"ok": certificate.ok, "checks": lines}


__all__ = ["certificate_data", "exit_code_of", "units_data", "warnings_data"]
