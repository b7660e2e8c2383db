"""Places where the ego must not stand, for tests of plans that leave them."""

from __future__ import annotations

from stucksolver.guard import Guard
from stucksolver.plan.behaviors import BackUp
from stucksolver.scene import ObjectKind, Zone, ZoneKind
from worlds import straight_road, thing

GUARD = Guard()
K, Z = ObjectKind, ZoneKind
HALF_M = 4.9 / 2
QUEUE = thing("queue", 58.5, stationary_s=40.0)
"""A car whose rear is 3.8 m ahead of the ego at 50 m: no room beyond the zone."""


def street(*spans, **road):
    return straight_road(**road, zones=tuple(Zone(kind=kind, start_m=a, end_m=b) for kind, a, b in spans))


def gate(x, y=-3.5):
    return thing(f"gate{x:.0f}", x, y, kind=K.CROSSING_GATE, length=0.3, width=1.0, height=3.0)


def codes(world, *behaviors, guard=GUARD, stops=False):
    return set(guard.accept(behaviors, world.view(), False, stops=stops)[0].codes)


CROSSING = street((Z.LEVEL_CROSSING, 20.0, 56.0))
"""Zone of 36 m around the rails. The ego at 50 m stands in its last third."""
BACK_OFF = BackUp(distance_m=34.0, speed_mps=2.0)
"""Off that zone: the front is then at 18.45 m."""
CROSSWALK = street((Z.CROSSWALK, 46.0, 52.0))
