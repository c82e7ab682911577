"""Draw scenes, maps, sections and diagrams off-screen, as PNG files.

================  ======================================================================
models.py         surfaces, a voxel search and a close-up in three dimensions
map.py            `draw_map`: a horizon with contours and intersection lines
isochores.py      `draw_thickness`: a thickness map of one zone
allan.py          `draw_allan`: the zones juxtaposed across a fault (Allan 1989)
section.py        `draw_section`: a vertical section
grid_section.py   `render_grid_section`: cells of a simulation grid
profile.py        `draw_throw`: throw along a fault
column.py         `draw_column`: the stratigraphic column
wells.py          well tops on maps and sections
backend.py        the choice of a graphics driver
probe.py          the test of one graphics driver, in a separate process
compose.py        content, frame and file of a picture
layers.py         layers and legend entries of a picture
surface_layers.py  triangles and lines of surfaces, patches and intersection lines
unit_layers.py    triangles and lines of units, together or exploded
clip.py           clipping to the model (Sutherland & Hodgman 1974)
views.py          directions of view and the parallel projection
sheet.py          a blank picture, or the axes of a user's figure
furniture.py      title, legend, arrows and scale bar
axes.py           axes of the model box
map_frame.py      axes, contour levels, colour bar and north arrow of maps
diagram.py        axes of sections and Allan diagrams
palette.py        colours
picture_style.py  `PictureStyle`: theme, font, colours by name, colour map
colouring.py      colours of units: by unit, zone, block, contact, elevation, property
names.py          names that are shortened and placed
overlay.py        `PictureOverlay`: wells, polygons and data points on pictures
_plot.py          layers drawn with VTK
================  ======================================================================

geosurf imports pyvista and VTK for the first picture.
Coordinates are shifted to the centre of the model in float64, because VTK computes in float32. The
same picture drawn twice has the same bytes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from geosurf.lazy import lazily

if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf.render.grid_section import render_grid_section as render_grid_section
    from geosurf.render.models import render_place as render_place
    from geosurf.render.models import render_search as render_search
    from geosurf.render.models import render_surfaces as render_surfaces
    from geosurf.render.views import VIEWS as VIEWS
else:
    __getattr__, __all__ = lazily(__name__)
