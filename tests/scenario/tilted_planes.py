"""A small scenario as text: two tilted planes and a fault."""

from __future__ import annotations

from tests.planes import INPUTS

TITLE = 'title = "Tilted planes"\n'
OUTPUT = """
[output]
views = ["southwest"]
search = ["Top", "F1"]
size_px = [400, 260]
"""
BODY = TITLE + INPUTS + OUTPUT
