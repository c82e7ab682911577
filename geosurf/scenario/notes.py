"""Notes of a run: what a user should look at in the model."""

from __future__ import annotations

from geosurf.model.column import CONFORMABLE
from geosurf.scene import Scene


def model_notes(scene: Scene) -> list[str]:
    """Return what a user should look at: in torn horizons, in the column, in fluid contacts."""
    # Notes are for people: what is a warning already is printed once.
    torn = [
        f"horizon {name!r}: {note}"
        for name, sheet in scene.sheets.items()
        for note in sheet.report.notes
        if note not in map(str, sheet.warnings)  # those are printed as warnings
    ]
    return [*torn, *crossings(scene), *contacts_left_out(scene)]


def crossings(scene: Scene) -> list[str]:
    """Return a note on each pair of conformable horizons that cross: no rule allows it."""
    # Crossings that a rule of the column explains are intended.
    return [
        f"{clip}. If this is not intended, list horizons youngest first, or set their rules."
        for clip in scene.units.report["clipped"]
        if clip.rule == CONFORMABLE
    ]


def contacts_left_out(scene: Scene) -> list[str]:
    """Return a note on each fluid contact that is given for some blocks, and not for others."""
    notes = []
    # A few units are named, the rest counted: blocks may be many.
    for name, left in scene.units.report["without_contact"].items():
        more = f" and {len(left) - 6} more" if len(left) > 6 else ""
        notes.append(
            f"fluid contact {name!r} does not split {', '.join(left[:6])}{more}: it is not given "
            "for their blocks. If this is not intended, add a table for these blocks, or one "
            "without a block."
        )
    return notes


__all__ = ["contacts_left_out", "crossings", "model_notes"]
