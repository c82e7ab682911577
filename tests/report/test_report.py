"""The page: complete, self-contained, the same each time."""

import re
from html.parser import HTMLParser

import pytest

from geosurf.model import Certificate, Check, Clipped, Remnant, Units
from geosurf.report import report_scene, tables
from geosurf.report.page import PAPER, Table, groups_of_columns, html_table
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
    dated = report_scene(scene, tmp_path / "one", made="2026-02-30").read_bytes()
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
