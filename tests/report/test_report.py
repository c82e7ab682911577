"""The page: complete, self-contained, the same each time."""

from __future__ import annotations

import base64
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from geosurf.model import Certificate, Check, Clipped, Remnant, TriSurface, Units
from geosurf.model.protocols import Body, View3D
from geosurf.render.interactive import view_of_surfaces, view_of_units
from geosurf.report import report_scene, tables
from geosurf.report.page import (
    PAPER,
    Table,
    asset,
    groups_of_columns,
    html_table,
    pack,
    viewer_html,
)
from geosurf.scene import Scene
from geosurf.scene import scene as room
from geosurf.scene.memory import Step
from geosurf.synthetic import tilted_planes
from tests.report.conftest import BOX, unit

PNG = b"\x89PNG\r\n\x1a\n" + b"not much of a picture"


class Reader(HTMLParser):
    """Collects tags, links and words; notes tags that do not match."""

    VOID = frozenset({"meta", "img", "link", "br", "input"})

    def __init__(self, html):
        super().__init__()
        self.open, self.crossed, self.links, self.words, self.ids = [], [], [], [], []
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        self.links += [value for key, value in attrs if key in ("src", "href")]
        self.ids += [value for key, value in attrs if key == "id"]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if self.open.pop() != tag:
            self.crossed.append(tag)

    def handle_data(self, data):
        self.words.append(data)


def test_a_model_that_was_checked_is_not_checked_again(tmp_path, monkeypatch):
    runs, certify = [], room.certify_repeated
    monkeypatch.setattr(room, "certify_repeated", lambda *a: runs.append(0) or certify(*a))
    world = tilted_planes(n=3)
    fresh = Scene(world.horizons, world.faults, world.box)
    for _ in range(2):
        assert "two runs give the same bytes" in report_scene(fresh, tmp_path, {}).read_text(
            encoding="utf-8"
        )
    assert len(runs) == 1
    assert fresh.certificate is fresh.certificate
    assert fresh.check() == fresh.certificate
    assert len(runs) == 2  # `check` always checks
    report_scene(fresh.replace(contacts={"OWC": -2200.0}), tmp_path, {})
    assert len(runs) == 3  # another model


def test_the_page_holds_everything_and_asks_for_nothing(scene, tmp_path):
    (tmp_path / "view.png").write_bytes(PNG)
    path = report_scene(scene, tmp_path / "new" / "report", {"A <view>": tmp_path / "view.png"})
    assert path == tmp_path / "new" / "report" / "index.html"
    html = path.read_text(encoding="utf-8")
    page = Reader(html)
    assert (page.open, page.crossed) == ([], [])
    inner = [link[1:] for link in page.links if link.startswith("#")]
    assert inner == page.ids
    assert len(set(page.ids)) == len(page.ids) > 5
    others = [link[:22] for link in page.links if not link.startswith("#")]
    assert others == ["data:image/png;base64,"]
    assert not re.search(r"https?://|@import|url\(", html)
    words = " ".join(page.words)
    for wanted in ("Top <&>", "A <view>", "all 10 checks passed", "of 6 units", "numpy"):
        assert wanted in words


def test_the_same_scene_gives_the_same_page(scene, tmp_path):
    one = report_scene(scene, tmp_path / "one").read_bytes()
    assert one == report_scene(scene, tmp_path / "two").read_bytes()
    dated = report_scene(scene, tmp_path / "one", title="2026-02-30").read_bytes()
    assert b"2026-02-30" in dated
    assert [path.name for path in (tmp_path / "one").iterdir()] == ["index.html"]


def test_a_failed_check_is_seen_first(scene, tmp_path):
    scene.check = lambda: Certificate((Check("closed", False, 3.0, "3 open edges"),))
    html = report_scene(scene, tmp_path).read_text(encoding="utf-8")
    assert html.index("A check FAILED") < html.index("(GRV)")
    assert '<td class="label failed">FAILED</td>' in html


def test_a_scene_that_draws_and_explains_is_asked_to(scene, tmp_path):
    def draw(folder, **choice):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "a.png").write_bytes(PNG)
        return {"From the south": folder / "a.png"}

    scene.render_pictures = draw
    scene.steps = (
        Step("curves", "F1", "ran", "1 <pair>"),
        Step("curves", "F1", "from memory", "1 <pair>"),
        Step("measure", "Top", "from memory", "2 rows"),
    )
    html = report_scene(scene, tmp_path / "r").read_text(encoding="utf-8")
    assert "From the south" in html
    # each step once, however often its result was at hand
    log = html.split("<pre>")[1].split("</pre>")[0].splitlines()
    assert [" ".join(line.split()) for line in log] == [
        "curves F1 ran 1 &lt;pair&gt;", "measure Top ran 2 rows"
    ]  # fmt: skip


def test_volumes_add_up_in_both_directions():
    two = [unit("above Top", 0, "F1-", 1e8), unit("below Top", 1, "F1+", 2e8)]
    units = Units(two, BOX, {"open_rim": {"F1": 12.5}})
    table = tables.volume_table(units)
    assert table.head == ("Zone", "F1-", "F1+", "all blocks")
    assert table.rows[0] == ("above Top", "100.000", "–", "100.000")
    assert table.foot == ("all zones", "100.000", "200.000", "300.000")
    assert "Relative difference: 0." in tables.balance(units)


def test_what_the_column_took_and_remnants_are_listed():
    places = ((1.0, 2.0, -3.0, 3.5e6),)
    clip = Clipped("Base", "Top", "erosional", 2e6, 3.5e6, 12.5, (1.0, 2.0, -3.0), places)
    (row,) = tables.clipped_table([clip]).rows
    assert row[:6] == ("Base", "Top", "erosional", "2.0000", "3.5000", "12.50")
    assert row[6:9] == ("1", "1.0", "2.0")
    (row,) = tables.remnant_table([Remnant("Top/Base F1+ #2", 99.5, (1.0, 2.0, -3.0))]).rows
    assert row[:4] == ("Top/Base F1+ #2", "99.5", "1.0", "2.0")
    assert tables.clipped_table([]).rows == ()


@pytest.mark.parametrize("n_column", [1, 5, 6, 7, 40])
@pytest.mark.parametrize("n_remark", [0, 1])
def test_every_column_is_printed_once_and_rows_keep_their_names(n_column, n_remark):
    head = ("Zone", "Rule", *(f"F{k}+ F{k + 1}-" for k in range(n_column)), "Remark")
    row = ("Top/Base", "base", *("123 456.789",) * n_column, "a long remark")
    size = len(head) - 1 + n_remark
    table = Table(head[:size], (row[:size],), n_label=2, n_remark=n_remark)
    parts = groups_of_columns(table)
    numbers = [k for part in parts for k in part if not table.holds_words(k)]
    assert numbers == list(range(2, 2 + n_column))
    for part in parts:
        assert part[:2] == [0, 1]
        assert (size - 1 in part) or not n_remark
        assert sum(len(row[k]) + 2 for k in part) <= PAPER
    html = html_table(table)
    assert html.count('class="paper"') == (len(parts) > 1)
    paper = html.partition('class="paper"')[2] or html
    for k in range(n_column):
        assert paper.count(f"<th>F{k}+ F{k + 1}-</th>") == 1


# ---- Colours of pages: from one list, light and dark, with the contrast that WCAG 2.1 AA asks for.
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


# ---- The interactive view: what the page holds is the model, and the browser draws and reacts.
@pytest.fixture(scope="module")
def units(planes):
    return planes.units


def unpacked(page):
    """Description and arrays of the bodies, read from the page as its script reads them."""
    head, data = (
        re.search(rf'class="view3d-{part}">(.*?)</script>', page, re.S)[1]
        for part in ("head", "data")
    )
    head, data = json.loads(head), base64.b64decode(data)
    for body in head["bodies"]:
        for name in ("points", "triangles", "lines"):
            kind, offset, count = body[name]
            body[name] = np.frombuffer(data, f"<{kind}", count, offset).astype(int)
    return head


def test_units_in_the_page_have_their_volume_names_and_numbers(units):
    head = unpacked(viewer_html(view_of_units(units)))
    assert sorted(body["name"] for body in head["bodies"]) == sorted(units)
    step, lower = np.array(head["step"]), np.array(head["lower"])
    for body in head["bodies"]:
        unit = units[body["name"]]
        p = body["points"].reshape(-1, 3) * step
        a, b, c = (p[body["triangles"].reshape(-1, 3)[:, k]] for k in range(3))
        volume = np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6.0

        # a step is 1/65 535 of the model: half of it along each normal
        assert volume == pytest.approx(unit.volume, abs=unit.area * step.max())
        assert np.abs((p + lower).max(axis=0) - unit.vertices.max(axis=0)).max() <= step.max()
        assert dict(body["facts"])["Zone"] == unit.zone
        assert dict(body["facts"])["Block"] == unit.block
        assert body["lines"].max() < len(p)


def test_names_cannot_end_the_script_and_the_page_is_the_same_twice(units):
    evil = "</script><script>alert(1)</script><!--"
    ramp = TriSurface(evil, "fault", [[0, 0, 0], [900, 0, 0], [0, 900, 500]], [[0, 1, 2]])
    page = viewer_html(view_of_surfaces([ramp]), evil)
    assert "alert(1)</script>" not in page
    assert page.count("<script") == page.count("</script>") == 3
    assert unpacked(page)["bodies"][0]["name"] == evil
    assert viewer_html(view_of_units(units)) == viewer_html(view_of_units(units))
    assert not re.search(r"https?:|url\(|@import|\ssrc=", page)


def test_a_body_of_one_point_more_than_two_bytes_count_is_numbered_with_four():
    def body(n):
        p = np.random.default_rng(1).random((n, 3))
        t = np.stack([np.arange(n), np.roll(np.arange(n), 1), np.roll(np.arange(n), 2)], axis=1)
        return Body("b", "g", (0, 0, 0), p, t, np.zeros(n, dtype=int), t[:, :2])

    for n, kind in ((65_536, "u2"), (65_537, "u4")):
        head, data = pack(View3D((body(n),), (0, 1, 0, 1, 0, 1)))
        (found,) = head["bodies"]
        assert found["triangles"][0] == kind
        assert np.frombuffer(data, f"<{kind}", n, found["triangles"][1]).max() == n - 1
