"""Elements that several scene classes share."""

from __future__ import annotations

from collections.abc import Sequence

from lab.benchmarks.guard_oracle.others import Other
from lab.benchmarks.guard_oracle.road import Road, lanes_of
from lab.benchmarks.guard_oracle.scene import Drawn, Setting, standing
from stucksolver.scene import ObjectKind, ZoneKind

K = ObjectKind
LONG_M = 330.0
"""Length of the road (m)."""
EGO_S = 70.0
"""Arc length of the ego (m)."""


def road(draw: Drawn, layout: str, *, bends: float = 0.3, zones: Sequence[tuple[ZoneKind, float, float]] = ()) -> Road:
    """Return a road with this layout; some roads bend."""
    width = draw.choice([3.25, 3.5, 3.5, 3.75])
    bend = draw.choice([-1, 1]) / draw.uniform(60.0, 250.0) if draw.random() < bends else 0.0
    limit = draw.choice([8.3, 13.9])
    key = f"{layout}-{width}-{bend:.6f}-{limit}-{zones}"
    return Road(key, [(LONG_M, bend)], lanes_of(layout, width), list(zones), limit)


def pose(draw: Drawn, setting: Setting, *, moving: float = 0.35, askew: float = 0.5) -> Setting:
    """Set the initial state of the ego: heading error up to 0.5 rad when slow, slightly off its lane's center."""
    setting.ego_s = EGO_S
    setting.ego_speed = draw.uniform(0.5, 5.5) if draw.random() < moving else 0.0
    most = 0.5 if setting.ego_speed < 1.0 else 0.5 / setting.ego_speed
    setting.ego_yaw = draw.uniform(-most, most) if draw.random() < askew else draw.uniform(-0.03, 0.03)
    setting.ego_d = draw.gauss(0.0, 0.2) if draw.random() < 0.7 else draw.uniform(-0.8, 0.8)
    return setting


def blocker(draw: Drawn, on: Road, name: str = "lead") -> Other:
    """Return a stopped object in the ego's lane a few meters ahead."""
    kind = draw.choice([K.CAR, K.CAR, K.VAN, K.TRUCK, K.BICYCLE, K.CONE, K.BARRIER])
    gap = draw.uniform(4.0, 22.0)
    aside = draw.uniform(-1.3, 0.5)
    found = standing(name, on, 0.0, 0.0, kind, turn=draw.gauss(0.0, 0.05))
    s = EGO_S + 2.45 + gap + found.body.length / 2
    x, y, heading = on.point_at(s, aside)
    found.body.x, found.body.y, found.body.yaw = x, y, heading + draw.gauss(0.0, 0.05)
    found.stood = draw.uniform(4.0, 60.0)
    found.hazard = draw.random() < 0.5
    return found
