"""Colours of pages: from one list, light and dark, with the contrast that WCAG 2.1 AA asks for."""

from __future__ import annotations

import re

import pytest

from geosurf.report.page import asset

TEXT, CONTROL = 4.5, 3.0
ON = {  # what is written or drawn on each background
    "paper": ("ink", "faint", "link", "red", "green"),
    "wash": ("ink", "faint", "link"),
    "amber-wash": ("ink", "faint", "amber", "link"),
    "green": ("on-badge",),
    "red": ("on-badge",),
}


def schemes() -> dict[str, dict[str, str]]:
    """Colours by name: light, dark and on paper; dark and paper replace some of light."""
    light, dark = re.findall(r":root \{(.*?)\}", asset("theme.css"), re.S)
    (paper,) = re.findall(r":root \{(.*?)\}", asset("page.css"), re.S)
    found = {}
    for name, text in (("light", light), ("dark", dark), ("print", paper)):
        pairs = re.findall(r"--([a-z-]+): (#[0-9a-f]{3,6})", text)
        found[name] = found.get("light", {}) | dict(pairs)
    return found


def luminance(code: str) -> float:
    """Relative luminance of sRGB, as WCAG 2.1 defines it."""
    code = code if len(code) == 7 else "#" + "".join(2 * digit for digit in code[1:])
    parts = [int(code[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one: str, other: str) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("scheme", schemes())
def test_text_can_be_read_in_every_scheme(scheme):
    colours = schemes()[scheme]
    for back, fronts in ON.items():
        for front in fronts:
            ratio = contrast(colours[front], colours[back])
            assert ratio >= TEXT, f"{scheme}: {front} on {back} is {ratio:.2f}"
    assert contrast(colours["faint"], colours["paper"]) >= CONTROL  # frames of controls
