"""A sealed model of another program -> a `Scene`: horizons, faults, and a box for its walls."""

from __future__ import annotations

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.errors import FormatError, ScenarioError
from geosurf.model import TriSurface
from geosurf.read.model3d import read_model3d
from geosurf.scenario.keys import ModelInput, Scenario
from geosurf.scene import Scene


def scene_of_sealed(scenario: Scenario, model: ModelInput, **options: object) -> Scene:
    """
    Read a sealed model as a scene.

    Parameters
    ----------
    scenario : Scenario
        For messages.
    model : ModelInput
    **options
        Of `Scene`: contacts, area of interest, voxel size.

    Returns
    -------
    Scene

    Raises
    ------
    ScenarioError
        If a horizon is named that the file does not have, or one is left out.
    FormatError
        If the file cannot be read, a surface has no kind, or the boundary is not a box.
    """
    surfaces = read_model3d(model.file, positive=model.positive, length_unit=model.length_unit)
    # The kind of each surface is stated in the model; nothing is guessed from names.
    roles: dict[str, dict[str, TriSurface]] = {"horizon": {}, "fault": {}, "wall": {}}
    for surface in surfaces.values():
        if surface.role not in roles:
            raise FormatError(
                f"{model.file}: surface {surface.name!r} is not marked as a horizon, a fault or a "
                "boundary. Set its kind in the model and export it again."
            )
        roles[surface.role][surface.name] = surface

    # the order of horizons is geology: the file's own, or the user's
    order = model.horizons or tuple(roles["horizon"])
    # Both ways: a name that is missing, and one that is unknown.
    for name in (*order, *roles["horizon"]):
        if name not in roles["horizon"] or name not in order:
            known = list(roles["horizon"])
            raise ScenarioError(
                f"{scenario.path}: model.horizons has {list(order)}, and {model.file.name} has "
                f"{known}; name each of these once, youngest first.{did_you_mean(name, known)}"
            )

    # in the order of the list, which is the stratigraphic one
    horizons = {name: roles["horizon"][name] for name in order}
    box = box_of_walls(list(roles["wall"].values()), str(model.file))
    return Scene(horizons, roles["fault"], box, **options)  # type: ignore[arg-type]


def box_of_walls(walls: list[TriSurface], file: str) -> tuple[float, ...]:
    """
    Return the box whose sides some walls are, exactly.

    Examples
    --------
    >>> from geosurf import build_walls
    >>> box_of_walls(build_walls((0, 9, 0, 8, -7, 0)), "model.ml")
    (0.0, 9.0, 0.0, 8.0, -7.0, 0.0)
    """
    bounds = np.array([wall.bounds for wall in walls]).reshape(-1, 6)
    if len(bounds):
        # each wall is flat in one axis and lies on one side of the box; all six sides occur
        low, high = bounds[:, ::2].min(axis=0), bounds[:, 1::2].max(axis=0)
        flat = bounds[:, ::2] == bounds[:, 1::2]
        sides = {
            (k, float(row[2 * k]))
            for row, f in zip(bounds, flat, strict=True)
            for k in range(3)
            if f[k]
        }
        wanted = {(k, float(value)) for k in range(3) for value in (low[k], high[k])}
        if flat.any(axis=1).all() and sides == wanted and len(wanted) == 6:
            return tuple(float(v) for pair in zip(low, high, strict=True) for v in pair)
    raise FormatError(
        f"{file}: its boundary is not a box with vertical and horizontal sides, which [model] "
        "needs. Export its surfaces, and give them as [[horizons]] and [[faults]] with an [aoi]."
    )
