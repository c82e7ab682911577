"""Maps and diagrams of a scene as figures of matplotlib, which notebooks show.

What draws is imported when it is needed: scenes without pictures start without it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from geosurf.conventions.packages import need_plots
from geosurf.model.expected import expect
from geosurf.model.protocols import PlottedModel

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from geosurf.render.overlay import PictureOverlay
    from geosurf.render.picture_style import PictureStyle

SIZE = (1280, 800)  # of a figure of its own [pixels]


class Look(TypedDict):
    """What all plots share, checked."""

    size: tuple[int, int]
    title: str | None
    style: PictureStyle


def look_of(ax: Any, size: Any, title: Any, style: Any) -> Look:
    """Return what all plots share, or raise an error before anything is computed."""
    need_plots()
    from geosurf.render.picture_style import style_of
    from geosurf.render.sheet import check_axes
    from geosurf.render.views import check_size

    if ax is not None:
        check_axes(ax)
    if title is not None:
        expect(title, str, "title must be text", "leave it out for the default title")
    return Look(size=check_size(size), title=title, style=style_of(style))


class ScenePlots:
    """The plots of a `Scene`: each needs only what any user of a scene can ask it for."""

    def plot_map(
        self: PlottedModel,
        horizon: str,
        ax: Axes | None = None,
        *,
        clip: bool = True,
        size: tuple[int, int] = SIZE,
        title: str | None = None,
        overlay: PictureOverlay | None = None,
        style: PictureStyle | None = None,
    ) -> Figure:
        """Draw the map of a horizon as a figure of matplotlib, or into axes.

        Parameters
        ----------
        horizon : str
        ax : matplotlib.axes.Axes, optional
            Where to draw, in world coordinates [m]. Default: a new figure.
        clip : bool
            Whether the map ends at the model.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        overlay : PictureOverlay, optional
            Wells, polygons and data points that are drawn with the model.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            ``figure.savefig("map.svg")`` writes any format of matplotlib.

        Raises
        ------
        InputError
            For an unknown horizon, or axes that are not axes.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.graben(n=9)
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> figure = scene.plot_map("Top", size=(640, 400))
        >>> figure.axes[1].get_xlabel()
        'Easting [km]'
        """
        from geosurf.render.map import plot_map
        from geosurf.render.overlay import overlay_of
        from geosurf.scene.picture_contents import map_of

        overlay = overlay_of(overlay)
        look = look_of(ax, size, title, style)
        surface, curves, options = map_of(self, horizon, clip)
        return plot_map(surface, curves, ax, **options, overlay=overlay, **look)

    def plot_thickness(
        self: PlottedModel,
        zone: str,
        ax: Axes | None = None,
        *,
        grid: Any = None,
        size: tuple[int, int] = SIZE,
        title: str | None = None,
        style: PictureStyle | None = None,
    ) -> Figure:
        """Draw the thickness map of a zone, with the fault polygons of its horizons.

        Parameters
        ----------
        zone : str
        ax : matplotlib.axes.Axes, optional
            Where to draw, in world coordinates [m]. Default: a new figure.
        grid : None, float or xarray object
            As for `thickness`. Default: 200 cells along the longer side of the box.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            For an unknown zone, or axes that are not axes.
        """
        from geosurf.render.isochores import plot_thickness
        from geosurf.scene.picture_contents import thickness_of

        look = look_of(ax, size, title, style)
        thickness, polygons = thickness_of(self, zone, grid)
        return plot_thickness(thickness, ax, polygons=polygons, **look)

    def plot_section(
        self: PlottedModel,
        line: Any,
        ax: Axes | None = None,
        *,
        size: tuple[int, int] = SIZE,
        title: str | None = None,
        overlay: PictureOverlay | None = None,
        style: PictureStyle | None = None,
    ) -> Figure:
        """Draw a vertical section along a line in the map.

        Parameters
        ----------
        line : array_like of float, shape (n, 2)
            As for `section` [m].
        ax : matplotlib.axes.Axes, optional
            Where to draw: distance along the section and elevation [m]. Default: a new figure.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        overlay : PictureOverlay, optional
            Wells, polygons and data points that are drawn with the model.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            For a line of fewer than two points, or axes that are not axes.
        """
        from geosurf.render.overlay import overlay_of
        from geosurf.render.section import plot_section
        from geosurf.scene.picture_contents import tops_of_scene

        overlay = overlay_of(overlay)
        look = look_of(ax, size, title, style)
        return plot_section(
            self.section(line), ax, tops=tops_of_scene(self), overlay=overlay, **look
        )

    def plot_allan(
        self: PlottedModel,
        fault: str,
        ax: Axes | None = None,
        *,
        size: tuple[int, int] = SIZE,
        title: str | None = None,
        style: PictureStyle | None = None,
    ) -> Figure:
        """Draw the Allan diagram of a fault.

        Parameters
        ----------
        fault : str
        ax : matplotlib.axes.Axes, optional
            Where to draw: distance along strike and elevation [m]. Default: a new figure.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            For an unknown fault, one with units on one side only, or axes that are not axes.
        """
        from geosurf.render.allan import plot_allan

        look = look_of(ax, size, title, style)
        zones = list(dict.fromkeys(unit.zone for unit in self.units.values()))
        return plot_allan(self.allan(fault), self.juxtaposition(fault), ax, zones=zones, **look)

    def plot_throw(
        self: PlottedModel,
        fault: str,
        ax: Axes | None = None,
        *,
        size: tuple[int, int] = SIZE,
        title: str | None = None,
        style: PictureStyle | None = None,
    ) -> Figure:
        """Draw the throw of all horizons along a fault.

        Parameters
        ----------
        fault : str
        ax : matplotlib.axes.Axes, optional
            Where to draw: distance along strike and throw [m]. Default: a new figure.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            For an unknown fault, one that no horizon meets, or axes that are not axes.
        """
        from geosurf.render.profile import plot_throw

        look = look_of(ax, size, title, style)
        names = self.horizon_names
        throws = {name: self.throw(name, fault) for name in names if self.cutoffs(name, fault)}
        throws = {name: found for name, found in throws.items() if np.isfinite(found.throw).any()}
        return plot_throw(throws, ax, horizons=names, **look)

    def plot_column(
        self: PlottedModel,
        ax: Axes | None = None,
        *,
        size: tuple[int, int] = (700, 800),
        title: str | None = None,
        style: PictureStyle | None = None,
    ) -> Figure:
        """Draw the stratigraphic column: zones with their mean thickness, horizons and their rules.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw. Default: a new figure.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            For axes that are not axes.
        """
        from geosurf.render.column import column_of, plot_column

        look = look_of(ax, size, title, style)
        # a fluid contact does not divide the thickness of its zone
        units = [(unit.zone, unit.volume, unit.zone_map_area) for unit in self.units.values()]
        zones = column_of(units, list(dict.fromkeys(zone for zone, _, _ in units)))
        return plot_column(zones, dict(self.column), ax, **look)
