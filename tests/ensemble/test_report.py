"""The page of an ensemble: its numbers are those of the results, and failures are not hidden."""

from __future__ import annotations

import hashlib
import re

import numpy as np
import pytest
from scipy import stats

import geosurf as gs
from geosurf.ensemble import (
    ContactLevel,
    DepthShift,
    Discrete,
    Ensemble,
    Normal,
    Triangular,
    Uniform,
)
from geosurf.ensemble.uncertain import words_of_distribution
from geosurf.errors import InputError, OutputError
from geosurf.report.page import number
from tests.messages import refused


@pytest.fixture(scope="module")
def result():
    world = gs.synthetic.tilted_planes(n=5)
    scene = gs.Scene(world.horizons, world.faults, world.box, contacts={"O$W$C": -2150.0})
    uncertain = [ContactLevel("O$W$C", shift=Uniform(-9, 9)), DepthShift("Top", Normal(0.0, 5.0))]
    return gs.run_ensemble(scene, 8, uncertain=uncertain, maps=400.0, progress=False).data


def without_maps(result):
    """The same without what most pictures of a page show."""
    maps = ["probability", "thickness_mean", "thickness_sd", "base_thickness", "layer"]
    return result.drop_vars([*maps, "juxtaposed_area"])


def test_the_page_has_all_quantiles_parameters_and_maps(result, tmp_path):
    page = Ensemble(result).report(tmp_path, title="Two <planes>").read_text(encoding="utf-8")
    assert "<h1>Two &lt;planes&gt;</h1>" in page
    for groups in (None, [("zone",)], [("block",)], [("unit",)]):
        for _, found in Ensemble(result).rows(groups=groups):
            for key in ("P90", "P50", "P10", "mean", "sd", "base"):
                assert number(found[key] / 1e6, 3) in page
    for words in (*result.parameter.values, *result.layer.values, "seed 0", "8 realisations built"):
        assert str(words) in page
    n_picture = 1 + 3 + result.sizes["layer"] + 1  # the last: its only fault
    assert len(re.findall("<img ", page)) == len([*(tmp_path / "pictures").iterdir()]) == n_picture
    assert "Failed realisations" not in page


def test_every_distribution_has_words_with_its_unit():
    assert words_of_distribution(5.0, "m") == "certain: 5 m"
    assert words_of_distribution(Triangular(0.0, 1.5, 4.0), "1") == (
        "triangular: 0 to 4, most likely 1.5"
    )
    assert words_of_distribution(Discrete(range(7)), "m") == "one of 0, 1, 2, 3, 4 m and 2 more"
    assert words_of_distribution([[0.0, 5.0]], "m") == "certain: list"
    assert words_of_distribution(stats.norm(3.0, 1.0), "m") == "scipy.stats.norm: median 3 m"


def test_base_cases_of_sums_add_up(result):
    whole = result.base_bulk.values.sum()
    for by in ("contact", "zone", "block", "unit"):
        assert Ensemble(result).quantiles(by, include="all").base.values.sum() == pytest.approx(
            whole
        )


def test_failures_and_files_are_listed_and_what_has_not_run_is_counted(result, tmp_path):
    broken = without_maps(result).copy(deep=True)
    broken.status[2], broken.status[5], broken.reason[2] = 2, 0, "horizons cross & <leak>"
    broken.bulk[[2, 5]] = np.nan
    (tmp_path / "top.txt").write_text("1 2 3")
    words = {"inputs": {"Top": tmp_path / "top.txt", "gone": tmp_path / "gone.txt"}}
    words["relative_to"] = tmp_path
    page = Ensemble(broken).report(tmp_path, **words).read_text(encoding="utf-8")
    assert Ensemble(broken).report(tmp_path, **words).read_text(encoding="utf-8") == page
    assert "6 realisations built, 1 failed; seed 0. 1 have not run yet." in page
    assert "horizons cross &amp; &lt;leak&gt;" in page
    assert "Maps" not in page
    assert all(words in page for words in result.parameter_distribution.values.tolist())
    assert "uniform: \N{MINUS SIGN}9 to 9 m" in page
    digest = hashlib.sha256(b"1 2 3").hexdigest()[:16]
    assert all(words in page for words in ("top.txt", digest, "gone.txt", "not found"))


def test_what_is_no_ensemble_is_refused(result, tmp_path):
    for wrong in (None, 5, result.drop_vars("status"), result.bulk):
        refused(InputError, "takes the data of an ensemble", Ensemble, wrong)
    (tmp_path / "file").write_text("")
    refused(OutputError, "file", lambda: Ensemble(result).report(tmp_path / "file"))
    with pytest.raises(InputError, match="no realisation of this ensemble has been built"):
        Ensemble(result.assign(status=("realisation", [2] * 8))).report(tmp_path)
