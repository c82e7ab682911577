"""Draw scenes, maps, sections and diagrams off-screen, as PNG files.

==================  ====================================================================
compose.py          pictures in three dimensions: surfaces, a voxel search, a close-up
map.py              `draw_map`: a horizon with contours and intersection lines
isochores.py        `draw_thickness`: a thickness map of one zone
allan.py            `draw_allan`: the zones juxtaposed across a fault (Allan 1989)
section.py          `draw_section`: a vertical section; cells of a simulation grid
diagram.py          axes of diagrams; `draw_throw` along a fault, `draw_column`
overlay.py          wells, polygons and data points on pictures; well tops
layers.py           layers and legend entries of a picture; names, shortened and placed
surface_layers.py   triangles and lines of surfaces, patches and units, few enough to draw
interactive.py      what an interactive view shows
clip.py             clipping to the model (Sutherland & Hodgman 1974)
views.py            directions of view and the parallel projection
backend.py          layers drawn with VTK, and the choice of a graphics driver
probe.py            the test of one graphics driver, in a separate process
sheet.py            a blank picture, or the axes of a user's figure
furniture.py        title, legend, axes, contours, colour bar, arrows and scale bar
artists.py          names of matplotlib; options of texts, lines and areas
picture_style.py    `PictureStyle`: theme, font, colours by name, colour map
colouring.py        colours of units: by unit, zone, block, contact, elevation, property
==================  ====================================================================

geosurf imports pyvista and VTK for the first picture.
Coordinates are shifted to the centre of the model in float64, because VTK computes in float32. The
same picture drawn twice has the same bytes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from geosurf.lazy import lazily

if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf.render.compose import render_place as render_place
    from geosurf.render.section import render_grid_section as render_grid_section
    from geosurf.render.views import VIEWS as VIEWS
else:
    __getattr__, __all__ = lazily(__name__)
