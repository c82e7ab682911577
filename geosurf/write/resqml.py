"""RESQML 2.0.1: horizons and faults with their interpretations, ``.epc`` and ``.h5``.

Grids are ``Grid2dRepresentation``: origin, steps and elevations where these give all nodes
exactly, else all coordinates. Meshes are ``TriangulatedSetRepresentation``. Arrays are float64 in
the HDF5 file. Identifiers follow from what is written, so that the same surfaces give the same
bytes.
"""

from __future__ import annotations

import hashlib
import io
import itertools
import re
import uuid
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePath
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from geosurf.conventions import elevation_sign, metres_per_unit
from geosurf.conventions.crs import are_same, epsg_of, label
from geosurf.conventions.machine import need
from geosurf.errors import OutputError
from geosurf.lazy import h5py
from geosurf.model import TriSurface
from geosurf.write.text_grids import refuse_odd_nodes
from geosurf.write.written import FileSet, Loss, declared_crs, own_name

# ---- resqml xml ----------------------------------------
# The XML of a RESQML 2.0.1 package: objects, relations, and where arrays lie in the HDF5 file.
#
# Element names and their order follow the schema of Energistics; resqpy and fesapi read them.


NAMESPACES = (
    'xmlns:resqml2="http://www.energistics.org/energyml/data/resqmlv2" '
    'xmlns:eml="http://www.energistics.org/energyml/data/commonv2" '
    'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
)
HEAD = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
OPC = "http://schemas.openxmlformats.org/package/2006"
RELATION = "http://schemas.energistics.org/package/2012/relationships"
# RESQML asks for a date; the same object has to give the same bytes, so it is always this one
CREATED = "1970-01-01T00:00:00Z"


@dataclass(frozen=True, eq=False)
class Part:
    """An object of the package.

    Attributes
    ----------
    kind : str
        Without ``obj_``.
    uuid, title, body : str
        `body` is the XML behind the citation.
    uses : list of Part
        The objects that it refers to.
    """

    kind: str
    uuid: str
    title: str
    body: str
    uses: Sequence[Part] = field(default_factory=list)

    @property
    def prefix(self) -> str:
        """Namespace of the object."""
        return "eml" if self.kind == "EpcExternalPartReference" else "resqml2"

    @property
    def content_type(self) -> str:
        """Content type as packages state it."""
        family = "eml" if self.prefix == "eml" else "resqml"
        return f"application/x-{family}+xml;version=2.0;type=obj_{self.kind}"

    @property
    def file(self) -> str:
        """Name in the package."""
        return f"obj_{self.kind}_{self.uuid}.xml"

    @property
    def xml(self) -> str:
        """The whole object."""
        about = (
            f"<eml:Title>{escape(self.title)}</eml:Title><eml:Originator>geosurf</eml:Originator>"
            f"<eml:Creation>{CREATED}</eml:Creation><eml:Format>geosurf</eml:Format>"
        )
        return (
            f'{HEAD}<{self.prefix}:{self.kind} {NAMESPACES} schemaVersion="2.0" '
            f'uuid="{self.uuid}" xsi:type="{self.prefix}:obj_{self.kind}">'
            f"<eml:Citation>{about}</eml:Citation>{self.body}</{self.prefix}:{self.kind}>\n"
        )


def tag(name: str, *values: object, kind: str = "", more: str = "") -> str:
    """An element of RESQML with a number, a word, or other elements; perhaps of a stated kind."""
    stated = f' xsi:type="{kind if ":" in kind else f"resqml2:{kind}"}"' if kind else ""
    return f"<resqml2:{name}{stated}{more}>{''.join(map(str, values))}</resqml2:{name}>"


def reference(name: str, part: Part) -> str:
    """An element that refers to another object."""
    return (
        f'<{name} xsi:type="eml:DataObjectReference">'
        f"<eml:ContentType>{part.content_type}</eml:ContentType>"
        f"<eml:Title>{escape(part.title)}</eml:Title><eml:UUID>{part.uuid}</eml:UUID></{name}>"
    )


def dataset(name: str, path: str, proxy: Part) -> str:
    """An element that names an array in the HDF5 file."""
    where = f"<eml:PathInHdfFile>{path}</eml:PathInHdfFile>{reference('eml:HdfProxy', proxy)}"
    return tag(name, where, kind="eml:Hdf5Dataset")


def crs_body(epsg: int | None, label: str | None) -> str:
    """Local coordinate system: metres, elevation positive up, no offset, no rotation."""
    unknown = "<eml:Unknown>{}</eml:Unknown>".format
    projected = (
        tag("ProjectedCrs", unknown(escape(label or "unknown")), kind="eml:ProjectedUnknownCrs")
        if epsg is None
        else tag(
            "ProjectedCrs", f"<eml:EpsgCode>{epsg}</eml:EpsgCode>", kind="eml:ProjectedCrsEpsgCode"
        )
    )
    return "".join(
        [
            tag("YOffset", 0),
            tag("ZOffset", 0),
            tag("ArealRotation", 0, more=' uom="rad"'),
            tag("ProjectedAxisOrder", "easting northing"),
            tag("ProjectedUom", "m"),
            tag("VerticalUom", "m"),
            tag("XOffset", 0),
            tag("ZIncreasingDownward", "false"),
            tag("VerticalCrs", unknown("unknown"), kind="eml:VerticalUnknownCrs"),
            projected,
        ]
    )


def lattice_points(
    origin: tuple[float, float], steps: tuple[float, float], shape: tuple[int, int], values: str
) -> str:
    """Points of a grid along the axes: origin, steps to the east and north, elevations."""
    # the slower axis first: rows go north
    offsets = ""
    for direction, step, n in zip(((0.0, 1.0), (1.0, 0.0)), steps[::-1], shape, strict=True):
        count = tag("Value", repr(step)), tag("Count", max(n - 1, 1))
        spacing = tag("Spacing", *count, kind="DoubleConstantArray")
        offsets += tag("Offset", tag("Offset", _point(*direction, 0.0)), spacing)
    lattice = tag("Origin", _point(*origin, 0.0)), offsets
    return tag(
        "Points",
        tag("SupportingGeometry", *lattice, kind="Point3dLatticeArray"),
        tag("ZValues", values, kind="DoubleHdf5Array"),
        kind="Point3dZValueArray",
    )


def explicit_points(values: str) -> str:
    """Points of which all coordinates are in the HDF5 file."""
    return tag("Points", values, kind="Point3dHdf5Array")


def whole_numbers(name: str, path: str, proxy: Part) -> str:
    """An element with whole numbers of the HDF5 file."""
    values = dataset("Values", path, proxy)
    return tag(name, tag("NullValue", -1), values, kind="IntegerHdf5Array")


def _point(*coordinates: float) -> str:
    return "".join(tag(f"Coordinate{k}", repr(v)) for k, v in enumerate(coordinates, 1))


def package(parts: Sequence[Part], h5_name: str) -> dict[str, str]:
    """All files of a package by name: objects, relations, table of contents."""
    overrides = "".join(
        f'<Override PartName="/{part.file}" ContentType="{part.content_type}"/>' for part in parts
    )
    files = {
        "[Content_Types].xml": (
            f'{HEAD}<Types xmlns="{OPC}/content-types"><Default Extension="rels" '
            'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
            '<Override PartName="/docProps/core.xml" ContentType='
            f'"application/vnd.openxmlformats-package.core-properties+xml"/>{overrides}</Types>\n'
        ),
        "_rels/.rels": _relations(
            f'<Relationship Id="CoreProperties" Type="{OPC}/relationships/metadata/core-properties"'
            ' Target="docProps/core.xml"/>'
        ),
        "docProps/core.xml": (
            f'{HEAD}<cp:coreProperties xmlns:cp="{OPC}/metadata/core-properties" '
            'xmlns:dcterms="http://purl.org/dc/terms/" xmlns:dc="http://purl.org/dc/elements/1.1/" '
            'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">'
            f'<dcterms:created xsi:type="dcterms:W3CDTF">{CREATED}</dcterms:created>'
            "<dc:creator>geosurf</dc:creator><cp:version>1.0</cp:version></cp:coreProperties>\n"
        ),
    }
    for part in parts:
        files[part.file] = part.xml
        files[f"_rels/{part.file}.rels"] = _relations(_of_part(part, parts, h5_name))
    return files


def _of_part(part: Part, parts: Sequence[Part], h5_name: str) -> str:
    """Relations of an object, in both directions."""
    relations = ""
    if part.prefix == "eml":
        relations = (
            f'<Relationship Id="Hdf5File" Type="{RELATION}/externalResource" '
            f'Target="{escape(h5_name, {chr(34): "&quot;"})}" TargetMode="External"/>'
        )
    for other in part.uses:
        relations += _relation(
            "mlToExternalPartProxy" if other.prefix == "eml" else "destinationObject", other
        )
    for other in parts:
        if part in other.uses:
            relations += _relation(
                "externalPartProxyToMl" if part.prefix == "eml" else "sourceObject", other
            )
    return relations


def _relation(word: str, other: Part) -> str:
    return f'<Relationship Id="_{other.uuid}" Type="{RELATION}/{word}" Target="{other.file}"/>'


def _relations(body: str) -> str:
    return f'{HEAD}<Relationships xmlns="{OPC}/relationships">{body}</Relationships>\n'


LONG_AGO = (1980, 1, 1, 0, 0, 0)  # the first date that a zip file can state
TAKES = "RESQML takes horizons, fault surfaces, a list or mapping of these, or a Scene."


def resqml_of_surfaces(obj: Any, path: Path, name: str | None, crs: str | None) -> FileSet:
    """
    Return the files ``path`` (``.epc``) and the ``.h5`` next to it.

    Parameters
    ----------
    obj : TriSurface, DataArray, Scene, or list or mapping of surfaces
    path : pathlib.Path
    name : str or None
        Of a single surface.
    crs : str or None
        For surfaces that declare none.

    Returns
    -------
    FileSet

    Raises
    ------
    OutputError
        If something else is among them, names repeat, or coordinate systems differ.
    DependencyError
        If h5py is not installed.
    """
    surfaces = _surfaces(obj, name, path)
    declared = {crs: None} if crs is not None else {}
    systems = [declared_crs(surface) for _, surface in surfaces]
    declared |= {system: None for system in systems if system is not None}
    first, *others = declared or (None,)
    for other in others:
        if first is None or other is None or not are_same(first, other):
            raise OutputError(
                f"{path}: surfaces are in different coordinate reference systems, "
                f"{label(str(first))} and {label(str(other))}. Reproject them with gs.reproject."
            )

    parts, arrays = _objects([_geometry(title, system) for title, system in surfaces], first)
    alone = Loss("topology", "Surfaces are separate: for the sealed model, write scene.units.")
    return file_set(path, parts, arrays, [alone, *lost_of_crs(first)])


def file_set(
    path: Path, parts: Sequence[Part], arrays: dict[str, np.ndarray], lost: list[Loss]
) -> FileSet:
    """Return the two files of a package; the first part stands for the HDF5 file."""
    h5_name = path.with_suffix(".h5").name
    files = {
        PurePath(path.name): zipped(package(parts, h5_name)),
        PurePath(h5_name): hdf5(arrays, parts[0].uuid),
    }
    apart = Loss("other", f"Arrays are in {h5_name}: move both files together.")
    return files, [apart, *lost], re.compile("|".join(map(re.escape, (path.name, h5_name))))


def _surfaces(obj: Any, name: str | None, path: Path) -> list[tuple[str, Any]]:
    """Names and surfaces of whatever holds them."""
    if hasattr(obj, "surfaces") and hasattr(obj, "units"):  # a Scene, which lies above this room
        obj = obj.surfaces
    if _is_surface(obj):
        titled = [(str(name or own_name(obj) or path.stem), obj)]
    elif isinstance(obj, Mapping):
        titled = [(str(key), value) for key, value in obj.items()]
    else:
        titled = [(own_name(one) or f"surface {k}", one) for k, one in enumerate(obj, 1)]

    wrong = [type(one).__name__ for _, one in titled if not _is_surface(one)]
    if wrong:
        raise OutputError(f"{path}: cannot write {wrong[0]}. {TAKES}")
    names = [title for title, _ in titled]
    twice = sorted({title for title in names if names.count(title) > 1})
    if twice:
        raise OutputError(f"{path}: two surfaces are called {twice[0]!r}. Rename one of them.")
    return titled


def _is_surface(obj: Any) -> bool:
    """Whether something is a mesh or a grid of two dimensions with coordinates."""
    if isinstance(obj, TriSurface):
        return True
    coords = getattr(obj, "coords", ())
    return getattr(obj, "ndim", 0) == 2 and "easting" in coords and "northing" in coords


def _geometry(title: str, surface: Any) -> tuple[str, str, dict[str, np.ndarray]]:
    """Name, role, and either arrays of a grid or vertices and triangles."""
    if not isinstance(surface, TriSurface):
        return title, "horizon", _grid_of_array(title, surface)
    lattice = surface.lattice
    if lattice is not None and surface.role == "horizon":
        x, y = lattice.horizontal()
        return title, "horizon", {"x": x, "y": y, "z": lattice.elevation}
    return title, surface.role, {"points": surface.vertices, "triangles": surface.triangles}


def _grid_of_array(title: str, horizon: Any) -> dict[str, np.ndarray]:
    """Easting, northing and elevation [m] of the nodes of a horizon."""
    what = f"horizon {title!r}"
    sign = elevation_sign(horizon.attrs.get("positive"), what)
    scale = sign * metres_per_unit(horizon.attrs.get("units"), what)
    refuse_odd_nodes(horizon, title)

    # rows go along northing where there are two axes
    axes = horizon.easting.ndim == horizon.northing.ndim == 1
    if axes:
        horizon = horizon.transpose(*horizon.northing.dims, *horizon.easting.dims)
    x, y, z = (np.asarray(a, np.float64) for a in (horizon.easting, horizon.northing, horizon))
    x, y = np.broadcast_arrays(x, y[:, None] if axes else y)
    return {"x": x, "y": y, "z": z if scale == 1.0 else z * scale}


def _objects(
    surfaces: list[tuple[str, str, dict[str, np.ndarray]]], crs: str | None
) -> tuple[list[Part], dict[str, np.ndarray]]:
    """All objects of the package, and the arrays of the HDF5 file by their paths."""
    fresh = _identifiers(surfaces, crs)
    proxy, system = frame_parts(fresh, crs)
    parts, arrays = [proxy, system], dict[str, np.ndarray]()
    for title, role, held in surfaces:
        meaning = interpretation(title, role, fresh)
        identifier = next(fresh)
        kind, body, new = _representation(held, f"/RESQML/{identifier}", proxy, system)
        meant = meaning[1:]
        head = "".join(reference("resqml2:RepresentedInterpretation", one) for one in meant)
        parts += [*meaning, Part(kind, identifier, title, head + body, (proxy, system, *meant))]
        arrays |= new
    return parts, arrays


def frame_parts(fresh: Iterator[str], crs: str | None) -> tuple[Part, Part]:
    """Return what stands for the HDF5 file, and the local coordinate system."""
    mime = "<eml:MimeType>application/x-hdf5</eml:MimeType>"
    named = (None, None) if crs is None else (epsg_of(crs), label(crs))
    proxy = Part("EpcExternalPartReference", next(fresh), "Hdf Proxy", mime)
    return proxy, Part("LocalDepth3dCrs", next(fresh), named[1] or "local", crs_body(*named))


def _identifiers(
    surfaces: list[tuple[str, str, dict[str, np.ndarray]]], crs: str | None
) -> Iterator[str]:
    """Endless UUIDs that follow from what is written."""
    digest = hashlib.sha256(repr(crs).encode())
    for title, role, held in surfaces:
        digest.update(f"{title}\0{role}".encode())
        for key, array in held.items():
            digest.update(f"{key}{array.shape}".encode())
            digest.update(np.ascontiguousarray(array).tobytes())
    return identifiers(digest.hexdigest())


def identifiers(seed: str) -> Iterator[str]:
    """Return endless UUIDs that follow from a text."""
    return (str(uuid.uuid5(uuid.NAMESPACE_OID, f"geosurf {seed} {k}")) for k in itertools.count())


def lost_of_crs(crs: str | None) -> list[Loss]:
    """Return what RESQML does not hold of a reference system."""
    if crs is None or epsg_of(crs) is not None:
        return []
    return [Loss("crs", f"RESQML stores {label(crs)} as an unknown system with a name.")]


DOMAIN = tag("Domain", "depth")


def interpretation(title: str, role: str, fresh: Iterator[str]) -> list[Part]:
    """Feature and interpretation of a horizon or fault; nothing for other surfaces."""
    kinds = {"horizon": ("Genetic", "Horizon"), "fault": ("Tectonic", "Fault")}
    if role not in kinds:
        return []
    boundary, meant = kinds[role]
    body = tag(f"{boundary}BoundaryKind", role)
    feature = Part(f"{boundary}BoundaryFeature", next(fresh), title, body)
    body = DOMAIN + reference("resqml2:InterpretedFeature", feature)
    return [feature, Part(f"{meant}Interpretation", next(fresh), title, body, (feature,))]


def _representation(
    held: dict[str, np.ndarray], folder: str, proxy: Part, system: Part
) -> tuple[str, str, dict[str, np.ndarray]]:
    """Kind, XML and arrays of a grid or a mesh."""
    role = tag("SurfaceRole", "map")
    if "points" in held:
        mesh = held["points"], held["triangles"]
        patch, to = triangle_patch(0, *mesh, folder, proxy, system)
        return "TriangulatedSetRepresentation", role + patch, to
    x, y, z = held["x"], held["y"], held["z"]
    n_row, n_col = z.shape
    steps = _steps(x, y)
    if steps is not None:
        to = {f"{folder}/zvalues": z}
        values = dataset("Values", f"{folder}/zvalues", proxy)
        nodes = lattice_points((float(x[0, 0]), float(y[0, 0])), steps, (n_row, n_col), values)
    else:
        to = {f"{folder}/points": np.stack([x, y, z], axis=-1)}
        nodes = explicit_points(dataset("Coordinates", f"{folder}/points", proxy))
    patch = tag(
        "Grid2dPatch",
        tag("PatchIndex", 0),
        tag("FastestAxisCount", n_col),
        tag("SlowestAxisCount", n_row),
        _geometry_of(nodes, system),
    )
    return "Grid2dRepresentation", role + patch, to


def triangle_patch(
    number: int, points: np.ndarray, triangles: np.ndarray, folder: str, proxy: Part, system: Part
) -> tuple[str, dict[str, np.ndarray]]:
    """Return the XML of one patch of triangles, and its arrays by their paths in the HDF5 file."""
    to = {f"{folder}/points_patch{number}": points, f"{folder}/triangles_patch{number}": triangles}
    at_points, at_triangles = to
    nodes = explicit_points(dataset("Coordinates", at_points, proxy))
    patch = tag(
        "TrianglePatch",
        tag("PatchIndex", number),
        tag("Count", len(triangles)),
        tag("NodeCount", len(points)),
        whole_numbers("Triangles", at_triangles, proxy),
        _geometry_of(nodes, system),
    )
    return patch, to


def _geometry_of(nodes: str, system: Part) -> str:
    local = reference("resqml2:LocalCrs", system)
    return tag("Geometry", local, nodes, kind="PointGeometry")


def _steps(x: np.ndarray, y: np.ndarray) -> tuple[float, float] | None:
    """Steps east and north that give all nodes to the last bit, if there are such."""
    if min(x.shape) < 2:
        return None
    row, column = np.arange(x.shape[0])[:, None], np.arange(x.shape[1])
    east, north = float(x[0, 1] - x[0, 0]), float(y[1, 0] - y[0, 0])
    exact = (x == x[0, 0] + column * east).all() and (y == y[0, 0] + row * north).all()
    return (east, north) if exact and east > 0.0 and north > 0.0 else None


def hdf5(arrays: dict[str, np.ndarray], proxy: str) -> bytes:
    """An HDF5 file of all arrays."""
    need("RESQML needs", "h5py")
    held = io.BytesIO()
    with h5py.File(held, "w") as file:
        file.create_group("RESQML").attrs["uuid"] = proxy
        for path, array in arrays.items():
            file.create_dataset(path, data=array)
    return held.getvalue()


def zipped(files: dict[str, str]) -> bytes:
    """A zip file without the present time."""
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED) as package_file:
        for name, text in files.items():
            info = zipfile.ZipInfo(name, LONG_AGO)
            info.compress_type = zipfile.ZIP_DEFLATED
            package_file.writestr(info, text)
    return held.getvalue()
