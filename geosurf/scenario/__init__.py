"""From a scenario file to results, in one call.

============  =========================================================
keys.py       every key: type, unit, default, meaning
drawn.py      of these: [search] and [output]
declared.py   how a key is declared
values.py     how values are checked, and what the messages say
inputs.py     file -> `Scenario` -> `Scene`
output.py     the output folder: new results whole, or the old ones
pictures.py   the pictures that a scenario asks for
execute.py    all of it, stage by stage
page.py       docs/scenario.md, from the keys
============  =========================================================
"""

from __future__ import annotations

from geosurf.scenario.execute import Outcome, run, run_scenario
from geosurf.scenario.inputs import read_scenario
from geosurf.scenario.keys import Scenario

__all__ = ["Outcome", "Scenario", "read_scenario", "run", "run_scenario"]
