"""Style sheets, scripts and markup of pages, and the frame that refuses the network.

=============  ====================================================================
theme.css      colours, light and dark
page.css       the report on the screen and on paper
page.js        sorting and filtering of tables, pictures that enlarge
viewer.css     the interactive view
viewer.html    the markup of its controls
viewer_*.js    parts of one script, see `viewer_script`
=============  ====================================================================
"""

from __future__ import annotations

import base64
import hashlib
from functools import cache
from html import escape
from pathlib import Path


@cache
def asset(name: str) -> str:
    """Return one of the files of this folder as text."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def viewer_script() -> str:
    """Return the script of the interactive view: model, painter, controls."""
    parts = ("model", "painter", "controls")
    code = "\n".join(asset(f"viewer_{part}.js") for part in parts)
    return f'"use strict";\n(() => {{\n{code}}})();\n'


def document(title: str, body: str, styles: tuple[str, ...], scripts: tuple[str, ...]) -> str:
    """Return a page whose policy allows these styles and scripts, data in it, and no network.

    Parameters
    ----------
    title : str
        Is escaped.
    body : str
        HTML.
    styles, scripts : tuple of str

    Returns
    -------
    str
    """
    style = "\n".join(styles)
    policy = "; ".join(
        [
            "default-src 'none'",
            "img-src data:",
            f"style-src {_hash(style)}",
            f"script-src {' '.join(map(_hash, scripts))}",
            "base-uri 'none'",
            "form-action 'none'",
        ]
    )
    code = "\n".join(f"<script>{script}</script>" for script in scripts)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title>
<style>{style}</style>
</head>
<body>
{body}
{code}
</body>
</html>
"""


def _hash(text: str) -> str:
    """The hash by which a policy allows an inline style or script."""
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"
