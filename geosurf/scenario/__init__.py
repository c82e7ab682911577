"""From a scenario file to results, in one call.

================  =============================================================
keys.py           every key: type, unit, default, meaning
output_keys.py    of these: [search], [output] and [pictures]
ensemble_keys.py  of these: [ensemble] and [[uncertain]]
declare.py        how a key is declared
values.py         how values are checked, and what a check accepts
validate.py       file -> `Scenario`: names and rules checked, no surface read
build.py          `Scenario` -> `Scene`
torn.py           of these: horizons torn at their faults
sealed.py         of these: a sealed model of another program
region_units.py   which unit a region of such a model is
execute.py        a run: all of it, stage by stage
output.py         the output folder: new results whole, or the old ones
grid.py           the simulation grid that a scenario asks for
pictures.py       the pictures that a scenario asks for
step_log.py       one line per step, and a picture of the place of an error
toml_text.py      the text: lines of keys, what is not TOML, keys set from outside
plan.py           what a run reads and writes
================  =============================================================
"""

from __future__ import annotations

from geosurf.scenario.build import build_scene
from geosurf.scenario.execute import Outcome, run, run_scenario
from geosurf.scenario.keys import Scenario
from geosurf.scenario.validate import read_scenario

__all__ = ["Outcome", "Scenario", "build_scene", "read_scenario", "run", "run_scenario"]
