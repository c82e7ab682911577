"""The exported field: what its files hold, against its truth found a second time."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import geosurf as gs
from geosurf.errors import InputError
from geosurf.synthetic import field_export
from geosurf.synthetic.export.geology import OUTLINE, STEP, inside, quadrature
from geosurf.synthetic.torn_horizon import exists, side_of
from tests.messages import refused

VARIANTS = ("grids", "points", "network")
FEET = {"Base": "ft"}


@pytest.fixture(params=VARIANTS)
def field(request, export):
    return export(request.param)


def points_of(field, name):
    """Points (n, 3) of a horizon as its file has them, and whether they are a grid."""
    path, words = field.files[name], {"positive": "down", "length_unit": FEET.get(name, "m")}
    if path.suffix == ".poi":
        ds = gs.read_points(path, **words)
        return np.stack([ds.easting, ds.northing, ds.elevation], axis=1), False
    grid = gs.read_horizon(path, **words)
    points = np.stack([grid.easting, grid.northing, grid.values], axis=-1).reshape(-1, 3)
    return points[np.isfinite(points[:, 2])], True


def fault_of(field, name):
    path = field.files[name]
    return gs.read_fault(path, positive=None if path.suffix == ".ts" else "down")


def near_faults(field, name, points, reach):
    """Whether points are nearer to a cut-off than this, in the map."""
    lines = [field.cutoff(name, fault, wall) for fault in field.faults for wall in "+-"]
    gaps, _ = cKDTree(np.concatenate(lines)[:, :2]).query(points[:, :2])
    return gaps < reach


# ---- files


def test_files_hold_the_true_elevations_away_from_faults(field):
    for name in field.horizons:
        points, is_grid = points_of(field, name)
        truth = field.elevation(name, points[:, 0], points[:, 1])
        far = inside(field.outline, *points[:, :2].T) & ~near_faults(
            field, name, points, 3.0 * STEP if is_grid else STEP
        )
        assert far.mean() > 0.3
        assert np.abs(points[far, 2] - truth[far]).max() < 2e-3  # of what text and float32 hold


def test_grids_are_smeared_at_faults_and_points_have_both_walls(export, tmp_path):
    for variant in ("grids", "points"):
        field = export(variant)
        points, _ = points_of(field, "Top")
        _, count = np.unique(points[:, :2].round(2), axis=0, return_counts=True)
        assert (count.max() > 1) == (variant == "points")
        truth = field.elevation("Top", points[:, 0], points[:, 1])
        assert np.nanmax(np.abs(points[:, 2] - truth)) > 5.0
    sharp = field_export(tmp_path, smear=0)
    points, _ = points_of(sharp, "Top")
    assert np.nanmax(np.abs(points[:, 2] - sharp.elevation("Top", *points[:, :2].T))) < 2e-3


def test_bytes_are_the_same_twice(export, tmp_path):
    field = export("network")
    folder = field.files["Top"].parent
    again = field_export(tmp_path, field.variant)
    names = {p.relative_to(folder) for p in folder.rglob("*") if p.is_file()}
    assert names == {p.relative_to(tmp_path) for p in tmp_path.rglob("*") if p.is_file()}
    assert len(names) > 10
    for name in names:
        assert (folder / name).read_bytes() == (tmp_path / name).read_bytes(), name
    assert again.volumes(step=100.0) == field.volumes(step=100.0)


# ---- faults


def test_sticks_stop_short_by_the_stated_amount(field):
    for name, missing in field.missing.items():
        sticks = fault_of(field, name).sticks
        lines = {(h, w): field.cutoff(h, name, w) for h in field.horizons for w in "+-"}
        axis = sticks[-1][0, :2] - sticks[0][0, :2]
        axis /= np.linalg.norm(axis)
        for stick in sticks:
            s = stick[:, :2].mean(axis=0) @ axis
            levels = [
                np.interp(s, *_sorted(line[:, :2] @ axis, line[:, 2]), left=np.nan, right=np.nan)
                for line in lines.values()
            ]
            if not np.isfinite(levels).all():
                continue
            slack = 3.0  # a stick leans across the lines
            if "up" in missing:
                assert abs(max(levels) - stick[:, 2].max() - missing["up"]) < slack
            if "down" in missing:
                assert abs(stick[:, 2].min() - min(levels) - missing["down"]) < slack
    # the branch: the last stick and the main fault
    main = gs.triangulate_sticks(fault_of(field, "F1"))
    gap = np.linalg.norm(main.vertices[:, None] - fault_of(field, "F2").sticks[-1], axis=2).min()
    assert field.missing["F2"]["end"] * 0.8 < gap < field.missing["F2"]["end"] + 70.0


def _sorted(s, z):
    order = np.argsort(s)
    return s[order], z[order]


# ---- truth


def test_throw_is_the_step_between_the_cut_offs(field):
    for name in field.faults:
        foot = field.cutoff("Middle", name, "-")
        throw = field.throw("Middle", name, foot[:, 0], foot[:, 1])
        known = np.isfinite(throw)
        assert known.mean() > 0.9
        assert throw[known].min() >= 0.0
        assert 30.0 < throw[known].max() < 90.0
        hang = field.cutoff("Middle", name, "+")
        axis = foot[-1, :2] - foot[0, :2]
        axis /= np.linalg.norm(axis)
        other = np.interp(foot[:, :2] @ axis, *_sorted(hang[:, :2] @ axis, hang[:, 2]))
        assert np.median(np.abs(foot[:, 2] - other - throw)[known]) < 0.5


def test_cut_offs_are_where_the_elevation_ends(field):
    for wall, sign in (("+", 1), ("-", -1)):
        line = field.cutoff("Top", "F1", wall)[50:-50:7]
        for step in (0.5, -0.5):
            east = line[:, 0] + step * np.cos(np.radians(22.0))  # across F1, down dip
            north = line[:, 1] + step * np.sin(np.radians(22.0))
            z = field.elevation("Top", east, north)
            if sign * step > 0:
                assert np.nanmax(np.abs(z - line[:, 2])) < 0.5
                assert np.isfinite(z).mean() > 0.95
            else:
                assert np.isnan(z).mean() > 0.95


def test_volumes_count_places_in_space(export):
    """A slow oracle: each place has one block by its sides and lies in a zone or not."""
    field = export("network")
    x, y, weight = quadrature(OUTLINE, 60.0)
    z = np.arange(-2000.0, -1600.0, 8.0)[:, None]
    sides = {
        name: side_of(fault, x, y, z) if name in ("F1", "F2", "F4") else None
        for name, fault in field.geology.faults.items()
    }
    tops = {h: np.full(z.shape[:1] + x.shape, np.nan) for h in field.horizons}
    for h, values in tops.items():
        for signs, sheet in field.geology.sheets(field.geology.horizon(h), x, y).items():
            there = exists(field.geology.faults, signs, *np.broadcast_arrays(x, y, z))
            values[there] = np.broadcast_to(sheet, values.shape)[there]
    for (zone, block), volume in field.volumes().items():
        upper, lower = (tops[h] for h in zone.split("/"))
        here = (z < upper) & (z > lower)
        for side in block.split():
            here &= sides[side[:-1]] == (1 if side[-1] == "+" else -1)
        counted = 8.0 * (here * weight).sum()
        assert counted == pytest.approx(volume, rel=2e-2), (zone, block)


# ---- refusals


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"variant": "grid"}, "variant is 'grid'.*grids"),
        ({"smear": 6}, "smear is 6"),
        ({"smear": 1.5}, "whole number"),
    ],
)
def test_wrong_arguments_are_refused(words, message, tmp_path):
    refused(InputError, message, field_export, tmp_path, **words)


# ---- from its files to a model, by its own scenario


def test_the_scenario_builds_the_true_field(export, tmp_path):
    field = export("grids")
    scene = gs.run_scenario(field.files["scenario"], tmp_path / "out", pictures=False)
    assert scene.check().ok
    for unit, volume in field.volumes(scene.aoi).items():
        assert scene.units[unit].volume == pytest.approx(volume, rel=1e-3), unit
