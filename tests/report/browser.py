"""Pages in a real browser: chromium without a screen, started once for a page."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
# faults of the page reach the console as errors, refusals of the policy too
CONSOLE = re.compile(r":(?:ERROR|WARNING|INFO):CONSOLE[^\]]*\] (.*)")
DRIVER = "GL Driver Message"  # the software renderer on its own speed

COLLECT = """
window.faults = [];
addEventListener("error", (event) => faults.push(event.message));
addEventListener("securitypolicyviolation", (event) => faults.push(event.blockedURI));
"""
TELL = """
let told;
try {{
  told = {{found: (() => {{ {script} }})(), faults}};
}} catch (error) {{
  told = {{found: null, faults: [...faults, String(error)]}};
}}
const note = document.createElement("pre");
Object.assign(note, {{id: "found", hidden: true}});
note.textContent = btoa(unescape(encodeURIComponent(JSON.stringify(told))));
document.body.append(note);
"""


@dataclass(frozen=True)
class Visit:
    """What a script found in a page, and what the browser complained of."""

    found: Any
    faults: list[str]
    console: list[str]
    pdf: bytes


def visit(html: str, script: str, folder: Path, *, width: int = 500) -> Visit:
    """Open a page, run a function body in it, and print the page as PDF."""
    browser = next(filter(None, map(shutil.which, NAMES)), None)
    if browser is None:
        pytest.skip("chromium is not installed: pages are not opened in a browser")
    file, pdf = folder / "visited.html", folder / "visited.pdf"
    file.write_text(_with_scripts(html, COLLECT, TELL.format(script=script)), encoding="utf-8")
    command = [browser, "--headless", "--no-sandbox", "--enable-unsafe-swiftshader"]
    command += ["--enable-logging=stderr", f"--window-size={width},900", "--hide-scrollbars"]
    command += ["--no-pdf-header-footer", f"--print-to-pdf={pdf}", "--dump-dom"]
    command += [f"--user-data-dir={folder / 'profile'}", "--virtual-time-budget=2000"]
    ran = subprocess.run(
        [*command, file.as_uri()], capture_output=True, text=True, timeout=120, check=False
    )
    told = re.search(r'<pre id="found"[^>]*>([^<]+)</pre>', ran.stdout)
    assert told, ran.stderr[-2000:]
    answer = json.loads(base64.b64decode(told[1]))
    console = [line for line in CONSOLE.findall(ran.stderr) if DRIVER not in line]
    return Visit(answer["found"], answer["faults"], console, pdf.read_bytes())


def _with_scripts(html: str, first: str, last: str) -> str:
    """Add two scripts to a page, and their hashes to its policy, which stays as it is otherwise."""
    for script in (first, last):
        digest = hashlib.sha256(script.encode()).digest()
        word = f"'sha256-{base64.b64encode(digest).decode()}'"
        assert "script-src " in html
        html = html.replace("script-src ", f"script-src {word} ", 1)
    html = html.replace("<title>", f"<script>{first}</script>\n<title>", 1)
    return html.replace("</body>", f"<script>{last}</script>\n</body>", 1)
