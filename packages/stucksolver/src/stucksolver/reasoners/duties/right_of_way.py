"""Who may rightly hold up an ego with a free road ahead."""

from __future__ import annotations

from stucksolver.reasoners.duties.observation import drives
from stucksolver.scene import ControlKind, LightState, ObjectKind, Scene, SceneObject

STANDS_S = 8.0
"""The stack is given this long to set off by itself, as crossing traffic is (`standoffs.FIRST_TURN_S`) (s)."""
CROSSING_M = 50.0
"""Crossing traffic nearer than this goes first (m)."""
LINE_M = 30.0
"""A light that is not green holds the ego up to this distance ahead (m)."""
SCENE_M, SCENE_BESIDE_M = 45.0, 8.0
"""A flagger, gate or school bus counts up to this distance ahead and to the side (m), as in `guard.traffic_rules`."""
SCENES = frozenset({ObjectKind.FLAGGER, ObjectKind.CROSSING_GATE, ObjectKind.SCHOOL_BUS})
SIREN_M = 80.0
"""A moving emergency vehicle with its lights on within this distance goes first (m)."""


def may_hold(scene: Scene) -> str | None:
    """Return, in words, who may rightly hold the vehicle up without being in its path, or None."""
    for control in scene.controls:
        lit = control.kind is ControlKind.TRAFFIC_LIGHT and control.state not in (LightState.GREEN, LightState.OFF)
        if lit and control.applies is not False and -1.0 < control.distance_m < LINE_M:
            return "a light ahead is not known to be green"
    for o in scene.objects:
        aside_m = min(abs(o.left_edge_m), abs(o.right_edge_m))
        if o.kind in SCENES and -10.0 < (o.gap_m or 0.0) < SCENE_M and aside_m < SCENE_BESIDE_M:
            return f"{o.kind.value} {o.id} may be holding up the traffic"
        if _sounds(o):
            return f"{o.kind.value} {o.id} has its lights on and goes first"
        comes = o.speed_across_mps * (o.left_edge_m + o.right_edge_m) < 0.0
        if _crosses(o) and comes:
            return f"{o.kind.value} {o.id} is coming from the side and goes first"
    return None


def siren_behind(scene: Scene) -> SceneObject | None:
    """Return an emergency vehicle with its lights on that comes up from behind, or None."""
    return next((o for o in scene.objects if _sounds(o) and o.x_m < 0.0 and o.speed_along_mps > 0.0), None)


def _sounds(o: SceneObject) -> bool:
    return o.kind is ObjectKind.EMERGENCY and bool(o.emergency_lights) and drives(o) and _away_m(o) < SIREN_M


def _crosses(o: SceneObject) -> bool:
    return drives(o) and _away_m(o) < CROSSING_M and abs(o.speed_across_mps) > abs(o.speed_along_mps)


def _away_m(o: SceneObject) -> float:
    return float((o.x_m**2 + o.y_m**2) ** 0.5)
