"""The report in a real browser, opened once: it draws, reacts, sorts, enlarges and prints."""

from __future__ import annotations

import zlib

import numpy as np
import pytest

from geosurf.model import TriSurface, Units
from geosurf.render.interactive import view_of
from geosurf.report import report_scene
from tests.report.browser import visit
from tests.report.conftest import BOX, changed, unit

N_BLOCK = 33
EVIL = "<img src=x onerror=alert(1)>"  # a name that would ask for something, if it were not escaped

VIEWER = """
const root = document.querySelector(".view3d"), { view } = root;
const canvas = root.querySelector("canvas");
const find = (name) => root.querySelector(`[data-do=${name}]`);
function colours() {
  view.draw(); // what was drawn can be read before the page is shown
  const { gl } = view.painter, all = new Uint8Array(4 * canvas.width * canvas.height);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, all);
  return all;
}
function pixels() {
  const seen = new Uint32Array(colours().buffer), paper = seen[0];
  let drawn = 0, sum = 0;
  seen.forEach((v, i) => { drawn += v !== paper; sum = (31 * sum + v) % 1000000007; });
  return [drawn / seen.length, sum];
}
const step = (name, value, event) => {
  if (value !== undefined) find(name)[typeof value === "boolean" ? "checked" : "value"] = value;
  find(name).dispatchEvent(new Event(event));
  return pixels();
};
// Units along the middle of a section, by place: what a reader who clicks there is told.
function cutAt(level) {
  step("level", level, "input");
  step("view", "west", "change");
  if (view.painter.cut()[0] > 0) step("flip", !find("flip").checked, "change");
  const { box, bodies } = view.painter, seen = [];
  const look = view.painter.camera(), rise = look.scale[1] * canvas.height / 2;
  for (let k = 1; k < 20; k += 2) {
    const z = box[4] + (box[5] - box[4]) * k / 20;
    const up = (z - look.centre[2]) * view.painter.state.exaggeration;
    const y = Math.round(canvas.height / 2 - rise * up);
    const row = view.painter.pick(Math.round(canvas.width / 2), y);
    seen.push([k / 20, row < 0 ? "" : bodies[row].name]);
  }
  step("view", "southwest", "change");
  return seen;
}
const found = { first: pixels() };
const at = [Math.round(canvas.width / 2), Math.round(canvas.height / 2)];
view.choose(view.painter.pick(...at));
found.picked = [find("name").textContent, find("facts").textContent];
view.choose(-1);
found.again = pixels();
found.nothing = view.painter.pick(2, 2);
found.explode = step("explode", 1, "input");
step("explode", 0, "input");
found.tall = step("exaggeration", 12, "input");
step("exaggeration", 1, "input");
found.cut = step("axis", "easting", "change");
found.section = cutAt(0.3);
found.level = step("level", 0.8, "input");
found.other = step("flip", !find("flip").checked, "change");
step("axis", "", "change");
found.top = step("view", "top", "change");
found.one = (root.querySelector("[data-row]").click(), pixels());
found.none = step("none", undefined, "click");
[...root.querySelectorAll("[data-row]")].at(-1).click();
found.curve = pixels();
found.all = step("all", undefined, "click");
return found;
"""


TABLES = """
const inputs = document.querySelector("#inputs");
const surfaces = [...inputs.querySelectorAll("table")].at(-1);
const column = (i) => [...surfaces.tBodies[0].rows].map((row) => row.cells[i].textContent);
const found = { before: column(0) };
const heads = surfaces.tHead.rows[0].cells;
heads[3].querySelector("button").click();
found.sorted = column(3);
found.state = heads[3].getAttribute("aria-sort");
heads[3].querySelector("button").click();
found.reversed = column(3);
const box = inputs.querySelector("input.filter");
box.value = "s1 fault";
box.dispatchEvent(new Event("input"));
found.filtered = [...surfaces.tBodies[0].rows].filter((row) => !row.hidden).length;
box.value = "";
box.dispatchEvent(new Event("input"));
document.querySelector("#pictures .enlarge").click();
const dialog = document.querySelector("dialog");
found.large = dialog.open && dialog.querySelector("img").naturalWidth;
dialog.querySelector("button").click();
found.wide = document.documentElement.scrollWidth <= innerWidth;
found.links = [...document.querySelectorAll(".contents a")]
  .every((link) => document.getElementById(link.hash.slice(1)));
return found;
"""


def png(width: int, height: int) -> bytes:
    """A grey picture."""
    rows = (b"\0" + b"\x80" * width) * height
    head = width.to_bytes(4) + height.to_bytes(4) + bytes([8, 0, 0, 0, 0])
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(rows)), (b"IEND", b""))
    body = b"".join(
        len(data).to_bytes(4) + kind + data + zlib.crc32(kind + data).to_bytes(4)
        for kind, data in chunks
    )
    return b"\x89PNG\r\n\x1a\n" + body


@pytest.fixture(scope="module")
def units(planes):
    return planes.units


@pytest.fixture(scope="module")
def volumes():
    return {(z, b): 1e6 * (101.001 + 97 * b + 4999 * z) for z in range(2) for b in range(N_BLOCK)}


@pytest.fixture(scope="module")
def seen(planes, units, volumes, tmp_path_factory):
    """The page of a model with many blocks and surfaces, opened and printed."""
    folder = tmp_path_factory.mktemp("browser")
    corners = np.array([[0, 0, -9], [1e3, 0, -9], [0, 1e3, -9]])
    surfaces = tuple(
        TriSurface(f"s{i}", "fault" if i % 2 else "horizon", corners + 7 * i % 5, [[0, 1, 2]] * i)
        for i in range(12)
    )
    blocks = (unit(EVIL * z or "Top", z, f"F{b}+", v) for (z, b), v in volumes.items())
    scene = changed(
        planes,
        **dict.fromkeys(("horizon_names", "fault_names", "horizons_inside", "faults_inside"), ()),
        surfaces=surfaces,
        coverage={surface.name: 1.0 for surface in surfaces},
        units=Units(blocks, BOX, {"open_rim": {"F1": 12.5}}),
        view_3d=lambda: view_of([units, planes.curves]),
    )
    (folder / "grey.png").write_bytes(png(64, 40))
    page = report_scene(scene, folder, {EVIL: folder / "grey.png"}, title=EVIL)
    script = f"const both = {{}}; both.view = (() => {{{VIEWER}}})();"
    script += f"both.tables = (() => {{{TABLES}}})(); return both;"
    return visit(page.read_text(encoding="utf-8"), script, folder)


def test_the_page_asks_for_nothing_and_nothing_fails_in_it(seen):
    assert (seen.faults, seen.console) == ([], [])


def test_the_units_are_drawn_and_every_control_changes_the_picture(seen, units):
    found = seen.found["view"]
    assert found["first"][0] > 0.1
    assert found["first"] == found["again"]
    assert found["picked"][0] in units
    assert f"Zone{units[found['picked'][0]].zone}" in found["picked"][1]
    assert found["nothing"] == -1
    order = ("first", "explode", "tall", "cut", "level", "other", "top", "one", "none")
    assert len({found[name][1] for name in order}) == len(order)
    assert found["cut"][0] < found["first"][0]
    assert found["none"][0] < 0.05 < found["all"][0]
    assert found["curve"][0] > found["none"][0]
    assert found["all"] == found["top"]


def test_a_section_shows_the_units_that_are_there(seen, planes):
    """What is picked in a section at 30 % of the width is the unit at that point of the model."""
    west, east, south, north, bottom, top = planes.box
    found = seen.found["view"]["section"]
    z = bottom + np.array([share for share, _ in found]) * (top - bottom)
    at = [west + 0.3 * (east - west), 0.5 * (south + north)]
    pixel = 4.0  # metres: next to a surface either unit is right
    near = [
        planes.sample([[*at, level + off] for level in z]).unit.values for off in (-pixel, 0, pixel)
    ]
    inside = (near[0] == near[1]) & (near[1] == near[2])
    assert inside.sum() > 5
    assert len(set(near[1][inside])) > 2
    assert [name for _, name in np.array(found)[inside]] == near[1][inside].tolist()


def test_tables_sort_and_filter_and_pictures_enlarge(seen):
    found = seen.found["tables"]
    assert found["before"] == [f"s{i}" for i in range(12)]
    counts = [str(i) for i in range(12)]
    assert (found["sorted"], found["state"]) == (counts, "ascending")
    assert found["reversed"] == counts[::-1]
    assert found["filtered"] == 2  # s1 and s11
    assert found["large"] == 64
    assert found["wide"]
    assert found["links"]
