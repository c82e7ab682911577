"""A map of one horizon, with a gap where each fault throws it down."""

from pathlib import Path

from field import SIZE, scene

pictures = scene.render_pictures(
    "out/gallery/maps",
    views=(),
    maps=True,
    thickness=False,
    allan=False,
    sections=[],
    exploded=False,
    size=SIZE,
)
top = next(path for caption, path in pictures.items() if caption.startswith("Top"))
Path("docs/pictures/map_00_Top.png").write_bytes(top.read_bytes())
