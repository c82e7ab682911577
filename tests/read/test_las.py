"""LAS: the path of a well by its curves, and tops along it."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import FormatError, GeosurfWarning, InputError

HEAD = (
    "# made by hand\n~Version\nVERS.   2.0 : CWLS\nWRAP.    NO : one line per depth\n~Well\n"
    "NULL. -999.25 : null\nWELL.   W-1 : name of the well\n~Curve\nDEPT.M  : measured depth\n"
    "GR  .GAPI : gamma\nX   .M  : easting\nY   .M : northing\nTVDSS.FT : depth\n~A\n"
)
ROWS = (
    "0 50 461000 5932000 -100\n500 51 461100 5932200 900\n700 -999.25 -999.25 5932300 1100\n"
    "1000 52 461300 5932200 1900\n"
)
TOPS = (
    "~Tops_Definition\nTOPN. : name\nTOPT.M : depth\n~Tops_Data | Tops_Definition\n"
    "Top 250\nBase 750\nDeep 5000\n"
)


def written(tmp_path, text):
    (tmp_path / "w.las").write_text(text)
    return tmp_path / "w.las"


def test_the_path_is_taken_from_its_curves(tmp_path):
    path = written(tmp_path, HEAD + ROWS)
    well = gs.read_points(path, positive="down")
    assert well.attrs["well"] == "W-1"
    assert well.md.values.tolist() == [0, 500, 1000]  # one station has no easting
    assert well.easting.values.tolist() == [461000, 461100, 461300]
    np.testing.assert_allclose(well.elevation, np.array([100, -900, -1900]) * 0.3048)
    found = gs.info(path)
    assert (found.format, found.read_with, found.count) == ("las", "read_points", 3)
    assert found.notes["columns"].startswith("x is X, y is Y, z is TVDSS, md is DEPT")
    assert found.notes["left out"] == "1 stations with -999.25"
    with pytest.raises(InputError, match="positive='down'"):
        gs.read_points(path)
    same = gs.read_points(path, positive="down", columns=("X", "Y", "TVDSS"))
    assert same.equals(well)


@pytest.mark.filterwarnings("ignore:1 of 3 rows")
def test_tops_lie_on_the_path(tmp_path):
    path = written(tmp_path, HEAD + ROWS + TOPS)
    with pytest.warns(GeosurfWarning, match="'Deep' in well 'W-1'.*is outside of the path"):
        tops = gs.read_tops(path, positive="down")
    assert tops.horizon.values.tolist() == ["Top", "Base"]
    assert tops.well.values.tolist() == ["W-1", "W-1"]
    assert tops.easting.values.tolist() == [461050, 461200]
    assert tops.northing.values.tolist() == [5932100, 5932200]
    np.testing.assert_allclose(tops.elevation, np.array([-400, -1400]) * 0.3048)
    assert gs.info(path).read_with == "read_tops"


def test_notes_parameters_and_curves_without_a_name_are_passed_over(tmp_path):
    plain = gs.read_points(written(tmp_path, HEAD + ROWS), positive="down")
    head = HEAD.replace("~A\n", "~Parameter\n-------\n~Other\nNote: stuck at 625 m\n~A\n")
    for old, new in (("GR  .GAPI", ".GAPI"), ("GR  .GAPI", "X   .GAPI")):
        text = head.replace(old, new).replace("X   .M", "EAST.M") + ROWS
        found = gs.read_points(
            written(tmp_path, text), positive="down", columns=("EAST", "Y", "TVDSS")
        )
        assert found.equals(plain)


DAMAGES = {
    "no path": (HEAD.replace("TVDSS", "TVDKB") + ROWS, "no curve of the LAS file is z; curves are"),
    "wrapped": (HEAD.replace("WRAP.    NO", "WRAP. YES") + ROWS, "the LAS file is wrapped"),
    "short": (HEAD + ROWS + "1200 5\n", "line 19: found 2 values, expected 5"),
    "word": (HEAD + ROWS.replace("461100", "46l100"), "line 16: found '46l100"),
    "back": (HEAD + ROWS + "900 5 1 2 3\n", "depths do not increase after 1000 m"),
    "empty": (HEAD, "no station with a position"),
    "header": (HEAD.replace("GR  .GAPI : gamma", "gamma") + ROWS, "line 10: found 'gamma'"),
    "unit": (HEAD.replace("TVDSS.FT", "TVDSS.US") + ROWS, "us"),
}


@pytest.mark.parametrize("case", DAMAGES)
def test_damaged_wells_get_one_sentence(tmp_path, case):
    text, message = DAMAGES[case]
    error = InputError if case == "unit" else FormatError
    with pytest.raises(error, match=message):
        gs.read_points(written(tmp_path, text), positive="down")


def test_tops_without_a_section_or_a_path_are_refused(tmp_path):
    with pytest.raises(FormatError, match="no section ~Tops with data"):
        gs.read_tops(written(tmp_path, HEAD + ROWS), positive="down")
    text = HEAD.replace("X   .M", "DX  .M").replace("Y   .M", "DY  .M")
    with pytest.raises(FormatError, match="no curve of the LAS file is x or y"):
        gs.read_tops(written(tmp_path, text + ROWS + TOPS), positive="down")
