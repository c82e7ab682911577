"""The XML of a RESQML 2.0.1 package: objects, relations, and where arrays lie in the HDF5 file.

Element names and their order follow the schema of Energistics; resqpy and fesapi read them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from xml.sax.saxutils import escape

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
        return (
            f'{HEAD}<{self.prefix}:{self.kind} {NAMESPACES} schemaVersion="2.0" '
            f'uuid="{self.uuid}" xsi:type="{self.prefix}:obj_{self.kind}">'
            f"<eml:Citation><eml:Title>{escape(self.title)}</eml:Title>"
            "<eml:Originator>geosurf</eml:Originator>"
            f"<eml:Creation>{CREATED}</eml:Creation><eml:Format>geosurf</eml:Format>"
            f"</eml:Citation>{self.body}</{self.prefix}:{self.kind}>\n"
        )


def reference(tag: str, part: Part) -> str:
    """An element that refers to another object."""
    return (
        f'<{tag} xsi:type="eml:DataObjectReference">'
        f"<eml:ContentType>{part.content_type}</eml:ContentType>"
        f"<eml:Title>{escape(part.title)}</eml:Title><eml:UUID>{part.uuid}</eml:UUID></{tag}>"
    )


def dataset(tag: str, path: str, proxy: Part) -> str:
    """An element that names an array in the HDF5 file."""
    return (
        f'<{tag} xsi:type="eml:Hdf5Dataset"><eml:PathInHdfFile>{path}</eml:PathInHdfFile>'
        f"{reference('eml:HdfProxy', proxy)}</{tag}>"
    )


def crs_body(epsg: int | None, label: str | None) -> str:
    """Local coordinate system: metres, elevation positive up, no offset, no rotation."""
    projected = (
        f'<resqml2:ProjectedCrs xsi:type="eml:ProjectedCrsEpsgCode"><eml:EpsgCode>{epsg}'
        "</eml:EpsgCode></resqml2:ProjectedCrs>"
        if epsg is not None
        else '<resqml2:ProjectedCrs xsi:type="eml:ProjectedUnknownCrs"><eml:Unknown>'
        f"{escape(label or 'unknown')}</eml:Unknown></resqml2:ProjectedCrs>"
    )
    return (
        "<resqml2:YOffset>0</resqml2:YOffset><resqml2:ZOffset>0</resqml2:ZOffset>"
        '<resqml2:ArealRotation uom="rad">0</resqml2:ArealRotation>'
        "<resqml2:ProjectedAxisOrder>easting northing</resqml2:ProjectedAxisOrder>"
        "<resqml2:ProjectedUom>m</resqml2:ProjectedUom><resqml2:VerticalUom>m</resqml2:VerticalUom>"
        "<resqml2:XOffset>0</resqml2:XOffset>"
        "<resqml2:ZIncreasingDownward>false</resqml2:ZIncreasingDownward>"
        '<resqml2:VerticalCrs xsi:type="eml:VerticalUnknownCrs"><eml:Unknown>unknown</eml:Unknown>'
        f"</resqml2:VerticalCrs>{projected}"
    )


def lattice_points(
    origin: tuple[float, float], steps: tuple[float, float], shape: tuple[int, int], values: str
) -> str:
    """Points of a grid along the axes: origin, steps to the east and north, elevations."""
    # the slower axis first: rows go north
    offsets = "".join(
        f"<resqml2:Offset><resqml2:Offset>{_point(*way, 0.0)}</resqml2:Offset>"
        '<resqml2:Spacing xsi:type="resqml2:DoubleConstantArray">'
        f"<resqml2:Value>{step!r}</resqml2:Value><resqml2:Count>{max(n - 1, 1)}</resqml2:Count>"
        "</resqml2:Spacing></resqml2:Offset>"
        for way, step, n in zip(((0.0, 1.0), (1.0, 0.0)), steps[::-1], shape, strict=True)
    )
    return (
        '<resqml2:Points xsi:type="resqml2:Point3dZValueArray">'
        '<resqml2:SupportingGeometry xsi:type="resqml2:Point3dLatticeArray">'
        f"<resqml2:Origin>{_point(*origin, 0.0)}</resqml2:Origin>{offsets}"
        "</resqml2:SupportingGeometry>"
        f'<resqml2:ZValues xsi:type="resqml2:DoubleHdf5Array">{values}</resqml2:ZValues>'
        "</resqml2:Points>"
    )


def explicit_points(values: str) -> str:
    """Points of which all coordinates are in the HDF5 file."""
    return f'<resqml2:Points xsi:type="resqml2:Point3dHdf5Array">{values}</resqml2:Points>'


def _point(*coordinates: float) -> str:
    return "".join(
        f"<resqml2:Coordinate{k}>{value!r}</resqml2:Coordinate{k}>"
        for k, value in enumerate(coordinates, 1)
    )


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
    found = []
    if part.prefix == "eml":
        found.append(
            f'<Relationship Id="Hdf5File" Type="{RELATION}/externalResource" '
            f'Target="{escape(h5_name, {chr(34): "&quot;"})}" TargetMode="External"/>'
        )
    for other in part.uses:
        word = "mlToExternalPartProxy" if other.prefix == "eml" else "destinationObject"
        found.append(_relation(word, other))
    for other in parts:
        if part in other.uses:
            word = "externalPartProxyToMl" if part.prefix == "eml" else "sourceObject"
            found.append(_relation(word, other))
    return "".join(found)


def _relation(word: str, other: Part) -> str:
    return f'<Relationship Id="_{other.uuid}" Type="{RELATION}/{word}" Target="{other.file}"/>'


def _relations(body: str) -> str:
    return f'{HEAD}<Relationships xmlns="{OPC}/relationships">{body}</Relationships>\n'
