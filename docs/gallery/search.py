"""How voxels find the triangles that can meet: the search for the curve of Top and F1."""

from pathlib import Path

from field import SIZE, scene

pictures = scene.render_pictures(
    "out/gallery/search",
    views=(),
    maps=False,
    thickness=False,
    allan=False,
    throw=False,
    sections=[],
    exploded=False,
    search=("Top", "F1"),
    size=SIZE,
)
(found,) = pictures.values()
Path("docs/pictures/search.png").write_bytes(found.read_bytes())
