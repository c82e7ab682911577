"""What notebooks show of a scene: a card of its inputs, what was computed, and warnings."""

from __future__ import annotations

from typing import Any

from geosurf.conventions import counted
from geosurf.conventions.card import Card
from geosurf.model.column import ENDS

MOST_WARNINGS = 5


def card_of(scene: Any) -> str:
    """Return inputs, what is computed already, and warnings; nothing is computed for it."""
    memory = scene._plain.memory
    ran = [step for step in memory.steps if step.outcome == "ran"]
    stages = dict.fromkeys(step.stage for step in ran)
    rows = [
        ("horizons", ", ".join(scene.horizon_names)),
        ("faults", ", ".join(scene.fault_names) or "none"),
        *_walls_in_words(scene),
        ("computed", ", ".join(stages) or "nothing yet: ask for curves, units or volumes"),
    ]
    if ran:
        rows.append(("time", f"{sum(step.seconds for step in ran):.2f} s"))
    notes = [str(warning) for warning in memory.warnings[:MOST_WARNINGS]]
    left = len(memory.warnings) - MOST_WARNINGS
    notes += [f"and {counted(left, 'warning')} more: scene.warnings"] if left > 0 else []
    return Card("Scene", rows, notes=notes).html()


def _walls_in_words(scene: Any) -> list[tuple[str, str]]:
    """The row of virtual walls: what they continue, and their joins once they are known."""
    # with horizons as they were given, if they are not torn yet
    graph = vars(scene).get("_graph", scene._plain)
    wanted = [name for name, ends in graph.inputs.compartments.items() if ends]
    if not wanted:
        return []
    if "_patches_and_ends" not in vars(graph):
        return [("virtual walls", f"of {', '.join(wanted)}")]
    along = [str(one) for one in scene.virtual_walls if one.side in ENDS]
    return [("virtual walls", "; ".join(along) or "none")]
