"""The scenario and the note that `field_export` writes next to the files of a field."""

from __future__ import annotations

from pathlib import Path

from geosurf.synthetic.export.truth import FieldTruth

FEET = "Base"  # the horizon whose file is in feet


def scenario_of(truth: FieldTruth) -> bytes:
    """The scenario (TOML) that builds a field from its files."""
    lines = ["# Run it with: geosurf run field.toml -o out", "", 'title = "Exported field"']

    # what a user has to find out about the files is written next to each key
    for name in truth.horizons:
        lines += _input("horizons", name, truth.files[name])
        if name == FEET:
            lines.append('length_unit = "ft" # z only; x and y are metres')
    for name in truth.faults:
        lines += _input("faults", name, truth.files[name])
        if name in truth.missing:
            lines.append('extend = ["up", "down"] # its sticks are too short')

    # a branch ends at its main fault, on the side where it is
    for name, fault in truth.geology.faults.items():
        if fault.branch is not None:
            main, sign = fault.branch
            part = "hanging wall" if sign > 0 else "footwall"
            lines += ["", "[[truncations]]", f'fault = "{name}"', f'main = "{main}"']
            lines += [f'keep = "{part}"', "extend = true # it stops short of its main fault"]
    lines += ["", "[tear] # gridding smeared the horizons across the faults"]
    return _text(lines)


def note_of(truth: FieldTruth) -> bytes:
    """A note for people: what the formats do not store, and what is odd."""
    lines = [
        f"Synthetic field, variant '{truth.variant}': files as other programs export them.",
        "x and y are metres. z is depth, positive down, in metres unless stated.",
        "",
    ]
    for name in (*truth.horizons, *truth.faults):
        path, missing = truth.files[name], truth.missing.get(name, {})
        unit = " z in feet." if name == FEET else ""
        short = "".join(
            f" Stops {metres:g} m short of {'the horizons' if side in ('up', 'down') else 'F1'}"
            f" ({side})."
            for side, metres in missing.items()
        )
        notch = " Its upper rim has a notch." if path.suffix == ".ts" else ""
        lines.append(f"{path.name}:{unit}{short}{notch}" if unit + short + notch else path.name)
    lines += ["", "field.toml: a scenario of these files; scenario.toml: the one of `geosurf new`."]
    lines += ["", "truth/: volumes, cut-off lines and throw as they are, not as they were picked."]
    lines.append("They are elevations, positive up, in metres; volumes are inside outline.pol.")
    return _text(lines)


def _input(table: str, name: str, path: Path) -> list[str]:
    lines = ["", f"[[{table}]]", f'name = "{name}"', f'file = "{path.name}"']
    return lines if path.suffix == ".ts" else [*lines, 'positive = "down"']


def _text(lines: list[str]) -> bytes:
    return ("\n".join(lines) + "\n").encode("ascii")
