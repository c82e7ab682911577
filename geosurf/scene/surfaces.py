"""What users hand to a scene -> surfaces: files are opened, grids triangulated."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.carve.fluids import check_zones
from geosurf.conventions import counted, did_you_mean, length_text, rising_diagonal
from geosurf.conventions.axes import vertical_axis
from geosurf.conventions.crs import crs_of, refuse_other_crs
from geosurf.errors import GeosurfWarning, HorizonError, InputError, collected, warn
from geosurf.model import FaultSticks, FluidContact, Lattice, Sheet, TriSurface
from geosurf.model.base import in_crs_of, with_crs
from geosurf.model.column import levels_of, names_of_zones
from geosurf.model.expected import path_of
from geosurf.model.network import in_order
from geosurf.model.tops import TieReport, TieSettings, Tops, tops_of
from geosurf.read import otherwise, read_fault, read_horizon, read_points, read_polygons, read_tops
from geosurf.read.file_info import kind_of_file
from geosurf.scene.inputs import Box, SceneInputs, are_one, changing, undeclared
from geosurf.scene.memory import Memory, known_fingerprint
from geosurf.triangulate import build_contacts, orient_fault, triangulate_fault, triangulate_horizon
from geosurf.triangulate.decimate import can_be_decimated, decimate_frame, strides_of
from geosurf.triangulate.grids import cropped, is_stored, lack_of_memory, read_stored, refusal
from geosurf.triangulate.horizon import (
    EXTRAPOLATED,
    decimated_horizons,
    horizon_over,
    never_changes,
)
from geosurf.triangulate.mesh import check_horizon_mesh
from geosurf.triangulate.outline import check_outline
from geosurf.triangulate.spikes import check_spikes

# ---- footprint ----------------------------------------
# Horizons that are to be torn, as grids or points: their data, and where they lie in the map.


BETWEEN = 3  # cells: scattered points may be twice as far apart, and still cover what is between

Options = Mapping[str, Any]
Lookup = Callable[[str], TriSurface]


def opened_horizon(value: Any, options: Options) -> Any:
    """Return the data of a horizon that is to be torn; a path is read, as points or as a grid."""
    if isinstance(value, str | Path):
        read = read_points if holds_points(value) else read_horizon
        value = read(value, **otherwise(options))
    return read_stored(value, "to be torn") if is_stored(value) else value


def holds_points(path: str | Path) -> bool:
    """Return whether a file holds points, in lines or not, and no grid or mesh."""
    readers = kind_of_file(path_of(path, "horizon"))[1].split(" or ")
    return (
        not {"read_points", "read_polygons"}.isdisjoint(readers) and "read_horizon" not in readers
    )


def footprint(name: str, data: Any, words: Mapping[str, Any]) -> TriSurface:
    """Return a horizon that is to be torn as a grid without holes, for box and area.

    Gaps at faults, and between points, are not the end of a horizon: they get the height of the
    nearest node.
    """
    from scipy.ndimage import binary_closing, binary_fill_holes, distance_transform_edt

    from geosurf.sheets.lattice.data import read_data

    picks = read_data(data, name, words.get("positive"), words.get("length_unit")).picks

    # one value per cell of the grid, NaN where there are no data
    z = picks.means.reshape(picks.frame.shape)
    present = np.isfinite(z)

    # scattered points leave cells empty between them: closing joins points up to twice BETWEEN
    # cells apart
    if not picks.on_nodes:
        present = binary_closing(np.pad(present, BETWEEN), iterations=BETWEEN)
        present = present[BETWEEN:-BETWEEN, BETWEEN:-BETWEEN]
    filled = binary_fill_holes(present)

    # row and column of the nearest cell with data, for every cell
    nearest = distance_transform_edt(np.isnan(z), return_distances=False, return_indices=True)
    elevation = np.where(filled, z[tuple(nearest)], np.nan)
    frame = picks.frame
    rising = rising_diagonal(frame.easting, frame.northing)
    lattice = Lattice(frame.easting, frame.northing, elevation, rising)
    made = TriSurface(name, "horizon", lattice=lattice)
    if made.n_triangle == 0:
        low, high = np.nanmin(z), np.nanmax(z)
        raise HorizonError(
            f"horizon {name!r}: its data cover no area. Easting is {extent(frame.easting)}, "
            f"northing {extent(frame.northing)}, elevation {low:.6g} to {high:.6g} m. If these are "
            "exchanged, name the columns: columns=[x, y, z], by name or by number.",
            surfaces=[name],
        )
    return with_crs(made, data.crs if isinstance(data, TriSurface) else crs_of(data))


def extent(values: np.ndarray) -> str:
    """
    Return the lowest and highest of some coordinates, in words.

    Examples
    --------
    >>> extent(np.array([3.0, 1.0]))
    '1 to 3 m'
    """
    return f"{np.nanmin(values):.7g} to {np.nanmax(values):.7g} m"


def with_empty_blocks(
    horizons: Mapping[str, TriSurface], filling: Mapping[str, bool | str]
) -> dict[str, TriSurface]:
    """
    Return horizons with nodes of those that they are pinched out onto, where they have none.

    The default area follows from these: the model fills blocks in which a horizon is missing.

    Examples
    --------
    >>> import geosurf as gs
    >>> top = gs.synthetic.tilted_planes(n=9).horizons["Top"]
    >>> west = gs.triangulate_horizon(top.where(top.easting < 2000), name="West")
    >>> both = {"West": west, "Top": gs.triangulate_horizon(top, name="Top")}
    >>> with_empty_blocks(both, {"West": "Top", "Top": False})["West"].bounds[:2]
    (0.0, 4000.0)
    """
    filled = dict(horizons)
    for name in in_order(filling):
        onto = filling[name]
        if isinstance(onto, bool):
            continue
        lattice, lattice_below = filled[name].lattice, filled[onto].lattice
        if lattice is None or lattice_below is None or lattice.shape != lattice_below.shape:
            continue
        z = np.where(np.isnan(lattice.elevation), lattice_below.elevation, lattice.elevation)
        made = TriSurface(name, "horizon", lattice=lattice.with_elevation(z))
        filled[name] = in_crs_of(made, [filled[name]])
    return filled


def grid_of_sheet(sheet: Sheet) -> TriSurface:
    """Return a torn horizon as a grid, without gaps at faults."""
    from geosurf.sheets.extend import as_lattice  # loaded by those who have sheets

    return as_lattice(sheet)


def warnings_of_extrapolation(horizon: TriSurface) -> list[GeosurfWarning]:
    """Return the warning of the nodes that `extend_horizon` gave a horizon, if it has some."""
    if EXTRAPOLATED not in horizon.vertex_data:
        return []
    from geosurf.sheets.extend import warning_of_extrapolation  # loaded by those who extend

    found = warning_of_extrapolation(horizon)
    return [] if found is None else [found]


def horizons_in_map(
    inputs: SceneInputs, surface_of_sheet: Callable[[Sheet], TriSurface], untied: Lookup
) -> list[TriSurface]:
    """Return all horizons for box and area, those that are pinched out with the nodes that lack.

    Parameters
    ----------
    inputs : SceneInputs
    surface_of_sheet : callable
        What stands for a torn horizon.
    untied : callable
        Horizon of a name, for all others.
    """
    in_map = {
        name: surface_of_sheet(value).renamed(name) if isinstance(value, Sheet) else untied(name)
        for name, value in inputs.horizons.items()
    }
    return [*with_empty_blocks(in_map, inputs.filling).values()]


# ---- decimated ----------------------------------------
# Horizons of a model within a tolerance: every k-th node, the same of all on one frame.


def decimated(
    inputs: SceneInputs, memory: Memory, whole: Callable[[str], TriSurface]
) -> dict[str, TriSurface]:
    """
    Return the horizons of a model that have fewer nodes, by name.

    Horizons whose grids have the same nodes in the map keep the same rows and columns, so that
    which of two is higher stays the same at every place, and where they coincide. All of them are
    within the tolerance of all their nodes, or none is decimated. None is in a scene without a
    tolerance, or whose horizons are tied to tops: a tie is exact with all nodes only.

    Parameters
    ----------
    inputs : SceneInputs
    memory : Memory
        Gets a step for each frame, with the largest difference.
    whole : callable
        Name of a horizon -> its surface with all nodes.

    Examples
    --------
    >>> import geosurf as gs
    >>> dome = gs.synthetic.dome_and_flat_fault(n=401).horizons["Top"]
    >>> top = gs.triangulate_horizon(dome, name="Top")
    >>> made = decimated(SceneInputs({"Top": top}, tolerance=0.5), Memory(), lambda name: top)
    >>> made["Top"].lattice.shape, bool(made["Top"].vertex_data["vertical_error"].max() < 0.5)
    ((101, 101), True)
    """
    decimated_by_name: dict[str, TriSurface] = {}
    tolerance = inputs.tolerance
    if tolerance is None or inputs.tie is not None:
        return decimated_by_name
    for frame in _frames([*map(whole, inputs.horizons)]):
        subject = ", ".join(horizon.name for horizon in frame)
        if (why := _needs_all(frame)) is not None:
            memory.note("decimate", subject, "skipped", f"all nodes: {why}")
            continue
        made = memory.get_or_compute(
            "decimate", subject, ("decimate", tolerance, *map(memory.key_of, frame)),
            partial(decimate_frame, frame, tolerance), _in_words, again=False,
        )  # fmt: skip
        decimated_by_name.update({horizon.name: horizon for horizon in made})
        for given, horizon in zip(frame, made, strict=False):  # which of its nodes follows from n
            memory.made_of(horizon, ("decimated", horizon.n_vertex, memory.key_of(given)))
    return decimated_by_name


def _frames(horizons: Sequence[TriSurface]) -> list[list[TriSurface]]:
    """Horizons that are grids, in groups that have the same nodes in the map."""
    groups: list[tuple[Lattice, list[TriSurface]]] = []
    for horizon in horizons:
        if horizon.lattice is None:
            continue
        for lattice, group in groups:
            if lattice.shares_map(horizon.lattice):
                group.append(horizon)
                break
        else:
            groups.append((horizon.lattice, [horizon]))

    return [group for _, group in groups]


def _needs_all(frame: list[TriSurface]) -> str | None:
    """Why the horizons of one frame keep all nodes, before these are looked at."""
    shape = None if frame[0].lattice is None else frame[0].lattice.shape
    if shape is None or not strides_of(shape):
        return "the grid is small"
    other = [horizon.name for horizon in frame if not can_be_decimated(horizon)]
    if not other:
        return None
    if any("vertical_error" in horizon.vertex_data for horizon in frame):
        return "of one, nodes have been left out already"
    return f"{other[0]} has absent nodes"


def _in_words(made: list[TriSurface]) -> str:
    """Every how many nodes are kept, and what that changes at most."""
    if not made:
        return "all nodes: fewer would be off by more than the tolerance"
    off = max(float(one.vertex_data["vertical_error"].max()) for one in made)
    return f"{made[0].n_vertex} nodes each, at most {off:.2g} m off"


# ---- wells ----------------------------------------
# Well tops of a scene: read, checked, and compared with the names of its horizons.


def opened_tops(tops: Any, options: dict[str, str | None]) -> Tops | None:
    """Return well tops, read from a file if they are a path; None if there are none."""
    if tops is None:
        return None
    if isinstance(tops, str | Path):
        tops = read_tops(tops, **otherwise(options))
    return tops_of(tops)


def warnings_of_names(tops: Tops, horizons: tuple[str, ...]) -> list[GeosurfWarning]:
    """Return a warning for each horizon of the tops that a scene does not have."""
    warnings = []
    for name in dict.fromkeys(tops.horizons):
        if name not in horizons:
            wells = ", ".join(dict.fromkeys(tops.wells[k] for k in tops.of(name)))
            effect = (
                f"{counted(len(tops.of(name)), 'well top')} of {name!r} (wells {wells}) cannot be "
                f"used: the scene has the horizons {', '.join(horizons)}."
                f"{did_you_mean(name, horizons)}"
            )
            remedy = "Rename the horizon in the tops, or leave these tops out."
            warnings.append(GeosurfWarning("tops", name, effect, remedy))
    return warnings


def tied_surface(
    name: str,
    plain: TriSurface,
    sheet: Sheet | None,
    faults: Sequence[TriSurface],
    tops: Tops,
    settings: TieSettings,
) -> tuple[TriSurface, TieReport]:
    """
    Return a horizon that meets its well tops, and what was done.

    Parameters
    ----------
    name : str
    plain : TriSurface
        The horizon as it is without tops.
    sheet : Sheet or None
        The same, if it was torn before: it is compared, and cannot be corrected any more.
    faults : sequence of TriSurface
        As the model has them.
    tops : Tops
    settings : TieSettings

    Raises
    ------
    InputError
        If a sheet that was torn before does not meet its tops.
    """
    from geosurf.sheets.tie import tie_horizon

    # data can be corrected before they are torn; a finished sheet can only be compared
    if sheet is None:
        tied = tie_horizon(name, plain, lambda data: data, faults, tops, settings)
        return tied.data, tied.report
    # a tolerance that is always met: nothing is corrected
    compared = TieSettings(settings.range, np.inf)
    with collected() as found:
        report = tie_horizon(name, plain, lambda _: sheet, faults, tops, compared).report
    for warning in found:
        if warning not in sheet.warnings:  # a tie before has issued those
            warn(warning)
    if report.before > settings.tolerance:
        raise InputError(
            f"horizon {name!r} is a sheet that was torn before, so that tops cannot be tied: it "
            f"misses them by up to {length_text(report.before)}. Give the data of the horizon in "
            "place of the sheet, or leave tie= out; scene.misfit() lists all tops."
        )
    return plain, report


def remembered_tie(
    memory: Memory,
    name: str,
    plain: TriSurface,
    sheet: Sheet | None,
    faults: Sequence[TriSurface],
    tops: Tops,
    settings: TieSettings,
) -> tuple[TriSurface, TieReport]:
    """Return what `tied_surface` returns, from memory if it is there.

    Parameters
    ----------
    memory : Memory
    name, plain, sheet, faults, tops, settings
        As for `tied_surface`.
    """
    content = (tops.wells, tops.horizons, tops.points.tobytes(), settings)
    key = ("tied", name, *map(memory.key_of, (plain, *faults)), content)
    tied: tuple[TriSurface, TieReport] = memory.get_or_compute(
        "tie", name, key,
        lambda: tied_surface(name, plain, sheet, faults, tops, settings),
        lambda result: str(result[1]), again=False,
    )  # fmt: skip

    # later stages find the tied surface by what it was made of
    memory.made_of(tied[0], key)
    return tied


Found = Callable[[str], TriSurface | None]


class InputSurfaces:
    """
    The horizons and faults of a scene as surfaces, each read when it is first requested.

    Parameters
    ----------
    inputs : SceneInputs
    memory : Memory

    Attributes
    ----------
    crs : dict of str to str
        Coordinate reference systems that inputs declare, as far as they have been read.

    Raises
    ------
    InputError
        When a surface is read that is in another coordinate reference system than those before.
    """

    def __init__(self, inputs: SceneInputs, memory: Memory) -> None:
        self.inputs, self.memory = inputs, memory
        self.crs: dict[str, str] = {}
        self._fingerprints: dict[str, str] = {}
        self._marks: dict[Any, Hashable] | None = None  # of all inputs, when the first one was read
        self._few: dict[str, TriSurface] = {}  # every k-th node of grids that are too large
        self._known: dict[str, TriSurface] = {}  # those that have been asked for
        self._maps: list[weakref.ref[Lattice]] = []  # as long as somebody holds them

    def __getstate__(self) -> dict[str, Any]:
        """All but the weak references, which do not pickle: they only save memory."""
        return {**self.__dict__, "_maps": []}

    def horizon(self, name: str, others: Lookup) -> TriSurface:
        """Return a horizon with all its nodes; one that is torn looks up its faults in `others`."""
        known = self.inputs.names
        return self._surface(
            name, "horizon", self.inputs.horizons[name], lambda k: others(k) if k in known else None
        )

    def fault(self, name: str) -> TriSurface:
        """Return a fault as given: neither extended nor truncated."""
        return self._surface(name, "fault", self.inputs.faults[name], None)

    def maps(self) -> list[Lattice]:
        """Return horizons that scenes of the family hold, one for each pair of 2-D coordinates."""
        alive = (one for ref in self._maps if (one := ref()) is not None)
        return [*{id(one.easting): one for one in alive}.values()]

    def _noted(self, surface: TriSurface) -> TriSurface:
        """The surface; others refer to its 2-D coordinates where theirs are the same."""
        lattice = surface.lattice
        if lattice is not None and lattice.easting.ndim == 2:
            self._maps.append(weakref.ref(lattice))
        return surface

    def _key(self, name: str, role: str, content: str) -> Hashable:
        """What the surface of an input depends on: what it held when read first, and options."""
        kind = f"{role} to tear" if name in self.inputs.torn else role
        return ("surface", name, kind, content, *self.inputs.options.values(), self.inputs.crs)

    def take_over(self, before: InputSurfaces, changes: Mapping[str, Any]) -> None:
        """Take over what another scene has read of the inputs that a change does not name."""
        if before._marks is None:
            return
        kinds = ("horizons", "faults", "contacts")
        named = {name for kind in kinds for name in changes.get(kind) or ()}
        named |= {(key,) for key in changes}
        old, new = changing(before.inputs), changing(self.inputs)
        self._marks = {}
        for name, value in new.items():
            again = {name, before.inputs.halves.whole_of(name)} & named
            if again or name not in before._marks or not are_one(value, old[name]):
                self._marks[name] = _mark(value)
                continue
            self._marks[name] = before._marks[name]
            if name in before._fingerprints and not isinstance(value, Sheet):
                self._fingerprints[name] = before._fingerprints[name]
        self.memory.take_over(before.memory, self._fingerprints)
        self._maps = [ref for ref in before._maps if ref() is not None]

    def _surface(self, name: str, role: str, value: Any, others: Found | None) -> TriSurface:
        """Read and triangulate one input, or take it from memory: stages ask dozens of times."""
        if name in self._known:
            return self._known[name]
        if role == "horizon" and is_stored(value):
            value = self._from_store(name, value)

        if isinstance(value, Sheet) and name not in self._fingerprints:
            value.surface_among(others)  # with other faults it must not come from memory
        key = self._key(name, role, self.content(name, value))
        with vertical_axis(self.inputs.time):
            surface = self.memory.get_or_compute(
                "triangulate", name, key,
                lambda: self._in_crs(self._made_of(name, role, value, others)),
                lambda found: f"{found.n_triangle} triangles", again=False,
            )  # fmt: skip

        self.memory.made_of(surface, key)

        # surfaces of one model have one reference system
        refuse_other_crs(name, surface.crs, self.crs)
        if surface.crs is not None:
            self.crs[name] = surface.crs
        self._known[name] = surface
        return surface

    def content(self, name: str, value: Any) -> str:
        """Return the fingerprint of an input as it was when the first one was read."""
        if name not in self._fingerprints:
            mark = self._marked()[name]
            if not isinstance(mark, str):
                self.unchanged(name)
            found = mark if isinstance(mark, str) else self.memory.hold(value)
            self._fingerprints[name] = found
        return self._fingerprints[name]

    def _marked(self) -> dict[Any, Hashable]:
        """What shows that inputs have changed: of all of them, when the first one is read."""
        if self._marks is None:
            inputs = changing(self.inputs).items()
            self._marks = {name: _mark(value) for name, value in inputs}
        return self._marks

    def unchanged(self, name: str | tuple[str]) -> None:
        """Refuse an input that is about to be read, if it has changed since the first one was read.

        A scene is what its inputs were then: a model of old and new data is nobody's.
        """
        value = changing(self.inputs)[name]
        if self._marked()[name] != _mark(value):
            what = f"the file {value}" if isinstance(value, str | Path) else repr("".join(name))
            raise InputError(
                f"{what} has changed since this scene read its first input, and the scene would "
                f"mix old and new data. Make a new scene, geosurf.Scene(...), of the data as they "
                "are now."
            )

    def _from_store(self, name: str, value: Any) -> Any:
        """A grid of a store in memory; of what is too large every k-th node, or the area."""
        if name in self._few:
            return self._few[name]
        grids = {
            horizon: da for horizon, da in self.inputs.horizons.items()
            if is_stored(da) and horizon not in self._known
        }  # fmt: skip
        grids[name] = value
        if lack_of_memory([*grids.values()]) is None:
            return read_stored(value, name)

        # horizons of one grid keep the same nodes: files are opened for this
        for horizon, given in self.inputs.horizons.items():
            if isinstance(given, str | Path) and horizon != name:
                data = _read(given, "horizon", self.inputs.options)
                grids.update({horizon: data} if is_stored(data) else {})
        if self.inputs.tolerance is not None:
            words = {horizon: undeclared(da, self.inputs.options) for horizon, da in grids.items()}
            self._few = decimated_horizons(grids, words, self.inputs.tolerance)
            return self._few[name]
        sides = self._sides()
        if sides is not None:
            grids = {horizon: cropped(da, horizon, sides) for horizon, da in grids.items()}
        lack = lack_of_memory([*grids.values()])
        if lack is not None:
            raise refusal(grids, lack)
        return read_stored(grids[name], name)

    def _sides(self) -> tuple[float, float, float, float] | None:
        """West, east, south and north of the area, or of the box; None if neither is given."""
        if self.inputs.aoi is None or self.inputs.takes_rectangle:
            return None if self.inputs.box is None else self.inputs.box[:4]
        outline = opened_outline(self.inputs.aoi)
        (west, south), (east, north) = outline.min(axis=0).tolist(), outline.max(axis=0).tolist()
        return west, east, south, north

    def _made_of(self, name: str, role: str, value: Any, others: Found | None) -> TriSurface:
        """The surface of an input."""
        self.unchanged(name)
        if name in self.inputs.torn:
            return self._footprint(name, value)
        made = as_surface(
            name, role, value, self.inputs.options, others, self.maps(), self._from_store
        )
        return self._noted(made) if role == "horizon" else made

    def _in_crs(self, surface: TriSurface) -> TriSurface:
        """A surface in the reference system of the scene, if it declares none itself."""
        crs = self.inputs.crs
        if crs is None:
            return surface
        refuse_other_crs(surface.name, surface.crs, {"crs": crs})
        return (
            in_crs_of(surface.renamed(surface.name), [self.inputs]) if not surface.crs else surface
        )

    def _footprint(self, name: str, value: Any) -> TriSurface:
        """A horizon that is to be torn, as a grid without holes; a sheet as it is."""
        if isinstance(value, Sheet):
            return value.surface.renamed(name)
        data = opened_horizon(value, self.inputs.options)
        return footprint(name, data, undeclared(data, self.inputs.options))


def _mark(value: Any) -> Hashable:
    """What shows that an input has changed; None for what nobody can change, or reads later."""
    if isinstance(value, str | Path):
        try:
            state = Path(value).stat()
        except OSError:
            return None  # whoever reads it says what is wrong
        return state.st_size, state.st_mtime_ns, state.st_ino
    fixed = isinstance(value, Sheet | TriSurface | FaultSticks | Tops | int | float | type(None))
    return None if fixed or is_stored(value) else known_fingerprint(value)


def as_surface(
    name: str,
    role: str,
    value: Any,
    options: Options,
    others: Found | None = None,
    maps: Iterable[Lattice] = (),
    from_store: Callable[[str, Any], Any] = lambda name, da: read_stored(da, name),
) -> TriSurface:
    """Return a horizon or fault as a surface, whatever it was.

    Parameters
    ----------
    name : str
    role : {"horizon", "fault"}
    value : path, xarray object, FaultSticks, TriSurface, (vertices, triangles) or Sheet
    options : mapping
        ``positive`` and ``length_unit``, for inputs that do not declare theirs.
    others : callable, optional
        Surface of a name, or None: a sheet asks for the faults that tear it.
    maps : iterable of Lattice
        Of other horizons with 2-D coordinates, which are held once where they are the same.
    from_store : callable
        Name and grid of a file that was opened and not read -> the grid in memory, or a surface.

    Returns
    -------
    TriSurface
        A fault has its normals in the hanging wall, however its file or mesh was wound.
    """
    # first whatever reads: paths become grids, sticks or surfaces; then one way for each kind
    opened = _read(value, role, options) if isinstance(value, str | Path) else value
    if role == "horizon" and is_stored(opened):
        opened = from_store(name, opened)
    if role == "horizon" and isinstance(opened, tuple | list):
        opened = triangulate_horizon(opened, name=name, **undeclared(opened, options))
    torn = isinstance(opened, Sheet)  # one that ends on its faults has been checked
    if torn:
        opened = opened.surface_among(others)

    if isinstance(opened, TriSurface):
        opened = opened.renamed(name, role)

        # sheets were checked when they were torn
        if role == "horizon" and not torn:
            check_horizon_mesh(opened)
            check_spikes(opened)
        return orient_fault(opened) if role == "fault" else opened

    given = opened is value and hasattr(opened, "coords")
    if role == "horizon":
        made = horizon_over(opened, maps, copy=given, name=name, **undeclared(opened, options))
        check_spikes(made)
        return made
    opened = _own(opened) if given else opened
    return triangulate_fault(opened, name=name, **undeclared(opened, options))


def _own(given: Any) -> Any:
    """A copy of an xarray object: a scene outlives what is done to its inputs afterwards.

    Values that nobody can write to are not copied.
    """
    if hasattr(given, "data_vars"):
        held = {name: variable.variable for name, variable in given.data_vars.items()}
    else:
        held = {"": getattr(given, "variable", None)}
    values = {name: getattr(variable, "_data", None) for name, variable in held.items()}
    if not all(map(never_changes, values.values())):
        return given.copy(deep=True)
    return given.copy(deep=True, data=values if hasattr(given, "data_vars") else values[""])


def opened_contacts(contacts: Mapping[str, Any], options: Options) -> dict[str, Any]:
    """Return fluid contacts, paths and grids as surfaces, for `build_contacts`."""
    return {name: _opened(name, value, options) for name, value in contacts.items()}


def fluids_of(
    inputs: SceneInputs, memory: Memory, box: Box, known: Mapping[str, str]
) -> tuple[list[TriSurface], list[FluidContact]]:
    """Return surfaces of fluid contacts, and the zones and blocks in which they count.

    `known` has the reference systems of the other surfaces; contacts in another one are refused.
    """
    systems = dict(known) if inputs.crs is None else {"crs": inputs.crs, **known}
    with memory.collecting():
        opened = opened_contacts(inputs.contacts, inputs.options)
        for name, value in opened.items():
            for level in levels_of(value):
                refuse_other_crs(name, getattr(level, "crs", None), systems)
        surfaces, contacts = build_contacts(opened, box)
    check_zones(contacts, names_of_zones(tuple(inputs.horizons)))  # before anything is cut
    return surfaces, contacts


def _opened(name: str, value: Any, options: Options) -> Any:
    """A contact with its paths read; a mapping has one for each block, a list several."""
    # nested as users give it: blocks, lists, and values inside
    if isinstance(value, FluidContact):
        return replace(value, at=_opened(name, value.at, options))
    if isinstance(value, list | tuple):
        return [_opened(name, part, options) for part in value]
    if isinstance(value, str) and _is_written_number(value):
        raise InputError(
            f"fluid contact {name!r} is the text {value!r}. Give a number without quotes: "
            f"{value.strip()}."
        )
    if isinstance(value, str | Path) or hasattr(value, "dims"):
        return as_surface(name, "horizon", value, options)
    if isinstance(value, Mapping) and not hasattr(value, "data_vars"):
        return {
            block: _opened(f"{name} in {block}", part, options) for block, part in value.items()
        }
    return value


def _is_written_number(text: str) -> bool:
    """Whether a text is a number: an elevation in quotes, not the path of a grid."""
    try:
        float(text)
    except ValueError:
        return False
    return not Path(text).exists()


def opened_outline(aoi: Any) -> np.ndarray:
    """Return the corners of an area of interest, given as an array or a file of polygons."""
    if isinstance(aoi, str | Path):
        aoi = read_polygons(aoi, positive="up")
    return check_outline(aoi)


def _read(path: Any, role: str, options: Options) -> Any:
    return (read_horizon if role == "horizon" else read_fault)(path, **otherwise(options))
