"""From a scenario file to results, in one call.

==============  =============================================================
keys.py         every key of the model: type, unit, default; docstrings say what it means
output_keys.py  every key of what a run varies, draws and writes
values.py       how a key is declared, how values and tables are checked
toml_text.py    the text: lines of keys, what is not TOML, keys set from outside
validate.py     file -> `Scenario`: names and rules checked, no surface read
build.py        `Scenario` -> `Scene`; also of a sealed model of another program
execute.py      a run: all of it, stage by stage
output.py       the output folder: new results whole, or the old ones; its files
step_log.py     one line per step, and a picture of the place of an error
new/            a scenario from the files of a field
==============  =============================================================
"""

from __future__ import annotations

from geosurf.scenario.build import build_scene
from geosurf.scenario.execute import Outcome, run, run_scenario
from geosurf.scenario.keys import Scenario
from geosurf.scenario.validate import read_scenario

__all__ = ["Outcome", "Scenario", "build_scene", "read_scenario", "run", "run_scenario"]
