"""Cameras and projection: right-handed, centred, and blind to where the origin is."""

import numpy as np
import pytest

from geosurf.errors import InputError
from geosurf.render import views

BOUNDS = (456000.0, 460000.0, 6780000.0, 6783000.0, -2500.0, -1700.0)


@pytest.mark.parametrize("view", views.VIEWS)
def test_every_view_is_a_right_handed_frame_with_up_upwards(view):
    frame = np.array(views.view_vectors(view))
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    assert frame[1] @ (0, 0, 1) >= -1e-12


@pytest.mark.parametrize("view", views.VIEWS)
def test_the_box_fills_the_picture_and_stays_inside(view):
    camera = views.aim(view, BOUNDS, (900, 600), 2.0)
    pixels = camera.to_pixels(views.corners(BOUNDS))
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    assert (low > -1e-6).all()
    assert (high < np.array([900, 600]) + 1e-6).all()
    assert ((high - low) / (900, 600)).max() == pytest.approx(1.0)


@pytest.mark.parametrize("bad", [0, -2.0, float("nan"), float("inf")])
def test_exaggeration_has_to_be_a_positive_number(bad):
    with pytest.raises(InputError, match=r"exaggeration is .*above 0.*Leave it out"):
        views.check_exaggeration(bad, BOUNDS)
