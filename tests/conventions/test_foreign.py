"""Places and lines of other packages, by objects that look like theirs."""

import numpy as np
import pytest

import geosurf as gs
from geosurf.conventions.checks import crs_of_foreign, lines_of_foreign, points_of_foreign
from geosurf.errors import FormatError, InputError
from geosurf.triangulate.outline import check_outline
from tests.messages import refused

SQUARE = [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0), (0.0, 0.0)]


class Shape:
    """As shapely has it: polygons have no coordinates of their own, and say so loudly."""

    def __init__(self, geom_type, coords=(), holes=(), parts=None):
        self.geom_type, self._coords, self.interiors = geom_type, coords, holes
        if geom_type == "Polygon":
            self.exterior = Shape("LinearRing", coords)
        if parts is not None:
            self.geoms = parts

    @property
    def coords(self):
        if self.geom_type == "Polygon":
            raise NotImplementedError
        return self._coords


class Frame:
    """As geopandas has it."""

    def __init__(self, shapes, crs=None):
        self.geometry, self.crs, self.geom_type = shapes, crs, None


class Polygons:
    """As xtgeo has it."""

    xname, yname, zname, pname = "X_UTME", "Y_UTMN", "Z_TVDSS", "POLY_ID"

    def __init__(self, points, z=0.0):
        x, y = np.array(points).T
        self.table = {"X_UTME": x, "Y_UTMN": y, "Z_TVDSS": 0 * x + z, "POLY_ID": 0 * x}

    def get_dataframe(self):
        return self.table


def test_points_and_lines_of_geopandas_and_shapely():
    cloud = Frame(
        [Shape("MultiPoint", parts=[Shape("Point", [(1, 2, 3)])]), Shape("Point", [(4, 5, 6)])]
    )
    assert points_of_foreign(cloud).tolist() == [[1, 2, 3], [4, 5, 6]]
    area = Shape("Polygon", SQUARE)
    assert [line.tolist() for line in lines_of_foreign(area)] == [[list(p) for p in SQUARE]]
    assert crs_of_foreign(Frame([area], "EPSG:23031")) == "EPSG:23031"
    for wrong in (Frame([area]), Frame([Shape("Point", [(1, 2)])])):
        refused(ValueError, "points in space", points_of_foreign, wrong)
    refused(ValueError, "holes", lambda: lines_of_foreign(Shape("Polygon", SQUARE, holes=[SQUARE])))


@pytest.mark.parametrize("area", [Shape("Polygon", SQUARE), Frame([Shape("Polygon", SQUARE)]),
                                  Polygons(SQUARE), Polygons(SQUARE, 1700.0)])  # fmt: skip
def test_areas_of_other_packages_are_outlines(area):
    assert check_outline(area).tolist() == [list(p) for p in SQUARE[:-1]]


def test_depths_of_xtgeo_are_not_taken_for_elevations():
    refused(ValueError, "elevation or depth", lambda: lines_of_foreign(Polygons(SQUARE, 1700.0)))
    with pytest.raises(InputError, match="elevation or depth"):
        gs.PictureOverlay(points={"picks": Polygons(SQUARE)})
    assert len(gs.PictureOverlay(polygons={"licence": Polygons(SQUARE)}).polygons["licence"]) == 1


def test_systems_of_gocad_lines_are_read(tmp_path):
    text = 'GOCAD PLine 1\nHEADER {{\nname:{0}\n}}\nGOCAD_ORIGINAL_COORDINATE_SYSTEM\nNAME "{1}"\n'
    text += "END_ORIGINAL_COORDINATE_SYSTEM\nILINE\nVRTX 1 0 0 5\nVRTX 2 9 0 5\nSEG 1 2\nEND\n"
    one, two = text.format("a", "EPSG:23031"), text.format("b", "EPSG:32631")
    (tmp_path / "one.pl").write_text(one)
    (tmp_path / "two.pl").write_text(one + two)
    assert gs.read_fault(tmp_path / "one.pl").crs == "EPSG:23031"
    refused(FormatError, "several coordinate reference systems", gs.read_fault, tmp_path / "two.pl")
