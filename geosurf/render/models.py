"""Draw a scene, surfaces or units in three dimensions."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from geosurf.conventions import did_you_mean, is_word
from geosurf.errors import InputError
from geosurf.model import Curves, TriSurface, Units
from geosurf.model.expected import expect, flag_of, listed, number_of
from geosurf.model.protocols import DrawnModel
from geosurf.render.clip import Prism, as_modelled
from geosurf.render.compose import draw_picture, png_path
from geosurf.render.layers import Content, show_outline
from geosurf.render.surface_layers import show_curves, show_patches, show_surfaces
from geosurf.render.unit_layers import show_units
from geosurf.render.views import SIZE, check_size, view_vectors

# what a scene can show, and the roles of surfaces that each word stands for
ROLES_SHOWN = {"horizons": "horizon", "faults": "fault", "walls": "wall", "surfaces": "surface"}
SHOWABLE = (*ROLES_SHOWN, "curves", "patches", "units")
_SHOW = f"give a list of any of {', '.join(SHOWABLE)}"


def render_scene(
    scene: DrawnModel,
    path: str | os.PathLike[str],
    *,
    view: str = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    show: Sequence[str] = ("horizons", "faults", "curves"),
    exploded: float = 0.0,
    clip: bool = True,
) -> Path:
    """Draw a scene; only the results that are shown are computed.

    Parameters
    ----------
    scene : Scene
        Or any object with ``box``, ``aoi`` and with those of ``surfaces``, ``curves``, ``patches``
        and ``units`` that are shown: see ``geosurf.model.protocols.DrawnModel``.
    path : path-like
        A ``.png`` file; its folder is created.
    view : str
        Position of the viewer: ``"southwest"``, ``"southeast"``, ``"northwest"``, ``"northeast"``,
        ``"south"``, ``"north"``, ``"east"``, ``"west"`` or ``"top"``.
    size : (int, int)
        Width and height in pixels.
    exaggeration : float, optional
        Vertical exaggeration. Default: a round number that suits the shape of the model. It is
        printed below the picture.
    show : sequence of str
        Any of ``"horizons"``, ``"faults"``, ``"walls"``, ``"surfaces"``, ``"curves"``,
        ``"patches"``, ``"units"``.
    exploded : float
        Gap between units, as a fraction of the size of the model box.
    clip : bool
        Whether surfaces and curves are clipped to the model box and the area of interest.

    Returns
    -------
    Path
        The picture.

    Raises
    ------
    InputError
        If the view or a word in `show` is unknown, or the picture is empty.
    OutputError
        If the file cannot be written.
    DependencyError
        If no graphics driver can draw. The message lists the packages to install.

    Examples
    --------
    >>> import tempfile
    >>> from types import SimpleNamespace
    >>> ramp = TriSurface("F1", "fault", [[0, 0, 0], [900, 0, 0], [0, 900, 500]], [[0, 1, 2]])
    >>> scene = SimpleNamespace(surfaces=(ramp,), box=(0, 900, 0, 900, -100, 600), aoi=None)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     render_scene(scene, f"{folder}/view.png", show=["faults"], size=(400, 250)).name
    'view.png'
    """
    view_vectors(view)
    check_size(size)
    png_path(path)
    clip = flag_of(clip, "clip")
    exploded = number_of(exploded, "exploded", "give a fraction of the size of the box, 0 or above")
    show = (show,) if isinstance(show, str) else listed(show, "show must be a list of words", _SHOW)
    for word in show:
        if not is_word(word, SHOWABLE):
            raise InputError(
                f"unknown word in show: {word!r}. Use any of {', '.join(SHOWABLE)}."
                f"{did_you_mean(word, SHOWABLE)}"
            )
    _check_scene(scene, show)

    # only what is shown is asked of the scene, so that nothing else is computed
    roles = {ROLES_SHOWN[word] for word in show if word in ROLES_SHOWN}
    content, box = Content(), scene.box
    outline = scene.aoi if clip else None
    within = Prism(box, outline) if clip else None
    if roles:
        # torn horizons end on their faults: what lies beyond is not part of the model
        shown = (as_modelled(scene, s) for s in scene.surfaces if s.role in roles)
        content += show_surfaces(shown, within)
    if "patches" in show:
        content += show_patches(scene.patches, within)
    if "units" in show:
        content += show_units(scene.units, exploded)
    if "curves" in show:
        content += show_curves(scene.curves, within=within)

    # an exploded model has no common outline or axes any more
    if outline is not None and not exploded:
        content += show_outline(outline, box[4])
    return draw_picture(
        content,
        path,
        title=_title(show),
        view=view,
        size=size,
        exaggeration=exaggeration,
        box=None if exploded else box,
        axes=not exploded,
        relief_of=box,
    )


def _check_scene(scene: object, show: Sequence[str]) -> None:
    """Raise an error if the scene lacks something that is to be shown."""
    for wanted in ("box", "aoi", *("surfaces" if word in ROLES_SHOWN else word for word in show)):
        if not hasattr(scene, wanted) or isinstance(scene, Mapping):
            raise InputError(
                f"render_scene takes a Scene; {type(scene).__name__} has no attribute {wanted!r}. "
                "Make a scene with geosurf.Scene(horizons, faults, box)."
            )


def _title(show: Sequence[str]) -> str:
    """Return the title: a list of what the picture shows."""
    # in the order of `SHOWABLE`, however the caller listed them
    words = ["intersection lines" if w == "curves" else w for w in SHOWABLE if w in show]
    if not words:
        return "Scene"
    head, last = ", ".join(words[:-1]), words[-1]
    return (f"{head} and {last}" if head else last).capitalize()


def render_surfaces(
    surfaces: Iterable[TriSurface],
    curves: Curves | None = None,
    *,
    path: str | os.PathLike[str],
    view: str = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    title: str = "Surfaces",
) -> Path:
    """Draw surfaces and, optionally, their intersection lines.

    Parameters
    ----------
    surfaces : iterable of TriSurface
        Horizons from the youngest to the oldest; they take the colours of the column in this order.
    curves : Curves, optional
    path : path-like
        A ``.png`` file; its folder is created.
    view, size, exaggeration
        As in `render_scene`.
    title : str

    Returns
    -------
    Path

    Raises
    ------
    InputError, OutputError, DependencyError
        As `render_scene`.

    Examples
    --------
    >>> import tempfile
    >>> ramp = TriSurface("F1", "fault", [[0, 0, 0], [900, 0, 0], [0, 900, 500]], [[0, 1, 2]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     render_surfaces([ramp], path=f"{folder}/ramp.png", size=(400, 250)).name
    'ramp.png'
    """
    content = show_surfaces(surfaces)
    if curves is not None:
        content += show_curves(curves)
    return draw_picture(content, path, title=title, view=view, size=size, exaggeration=exaggeration)


def render_units(
    units: Units,
    path: str | os.PathLike[str],
    *,
    explode: float = 0.3,
    view: str = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    title: str = "Units by zone and block",
) -> Path:
    """Draw the units of a model in an exploded view: zones up and down, blocks sideways.

    Parameters
    ----------
    units : Units
        Each zone has a colour, each block a shade of it; the legend lists the volumes.
    path : path-like
        A ``.png`` file; its folder is created.
    explode : float
        Gap between units, as a fraction of the size of the model box; 0 for no gap.
    view, size, exaggeration
        As in `render_scene`.
    title : str

    Returns
    -------
    Path

    Raises
    ------
    InputError, OutputError, DependencyError
        As `render_scene`.
    """
    expect(units, Units, "render_units takes Units", "pass scene.units")
    explode = number_of(explode, "explode", "give a fraction of the size of the box, 0 or above")
    note = "" if explode == 0.0 else "Exploded view."
    return draw_picture(
        show_units(units, explode),
        path,
        title=title,
        note=note,
        view=view,
        size=size,
        exaggeration=exaggeration,
        box=units.box if explode == 0.0 else None,
        axes=explode == 0.0,
        relief_of=units.box,
    )
