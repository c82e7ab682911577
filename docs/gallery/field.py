"""The faulted reservoir: three horizons that gridding smeared across three faults, two contacts."""

import geosurf as gs

SIZE = (960, 600)
scene = gs.run_scenario(
    "data/synthetic_horizons/faulted_reservoir.toml", "out/gallery", pictures=False
)
