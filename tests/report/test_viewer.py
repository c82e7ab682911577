"""The interactive view: what the page holds is the model, and the browser draws and reacts."""

from __future__ import annotations

import base64
import json
import re

import numpy as np
import pytest

import geosurf as gs
from geosurf.model import TriSurface
from geosurf.model.protocols import Body, View3D
from geosurf.render.interactive import view_of_surfaces, view_of_units
from geosurf.report.page import pack, viewer_html


@pytest.fixture(scope="module")
def units():
    world = gs.synthetic.tilted_planes(n=5)
    return gs.Scene(world.horizons, world.faults, world.box).units


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
        rows = np.zeros(n, dtype=int)
        return Body("b", "g", (0, 0, 0), p, t, rows, t[:, :2])

    for n, kind in ((65_536, "u2"), (65_537, "u4")):
        head, data = pack(View3D((body(n),), (0, 1, 0, 1, 0, 1)))
        (found,) = head["bodies"]
        assert found["triangles"][0] == kind
        assert np.frombuffer(data, f"<{kind}", n, found["triangles"][1]).max() == n - 1
