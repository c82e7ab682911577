"""Worlds that nothing was chosen by: other faults, dips, strikes, throws and steps of the grid."""

from __future__ import annotations

from geosurf.synthetic.torn_horizon import Fault

BELL = Fault(1000, 1000, strike=75.0, dip=58.0, half=640.0, throw=55.0, profile="bell")
RELAY = {
    "F1": Fault(650, 900, strike=8.0, dip=65.0, half=520.0, throw=40.0),
    "F2": Fault(1250, 1250, strike=14.0, dip=65.0, half=560.0, throw=50.0),
}
PUSH = Fault(1000, 1000, strike=118.0, dip=38.0, half=650.0, throw=-50.0)


def crack(x: float, y: float, strike: float, dip: float, half: float, throw: float) -> Fault:
    """A fault whose throw dies as a root."""
    return Fault(x, y, strike=strike, dip=dip, half=half, throw=throw, profile="ellipse")


# name: faults, nodes per side, step [m], whether points with several values per node are needed
WORLDS: dict[str, tuple[dict[str, Fault], int, float, bool]] = {
    "bell": ({"F1": BELL}, 81, 25.0, False),
    "relay": (RELAY, 81, 25.0, False),
    "push": ({"F1": PUSH}, 81, 25.0, True),
    "crack": ({"F1": crack(1050, 1000, 131.0, 66.0, 480.0, 45.0)}, 81, 25.0, False),
    "half crack": ({"F1": crack(1600, 700, 112.0, 60.0, 900.0, 50.0)}, 81, 25.0, False),
    "push crack": ({"F1": crack(1000, 1000, 200.0, 50.0, 600.0, -45.0)}, 81, 25.0, True),
}
