"""Breaks a standoff: two vehicles that face each other both stand and wait for the other one.

Two vehicles with this add-on would do the same at the same time, for ever. Each draws a number, from which its reasoner
may conclude who yields, and asks again after a time that depends on it. Each further period has another draw.
"""

from __future__ import annotations

import math
import random

from stucksolver.plan import WaitReason
from stucksolver.scene import MOTOR_VEHICLES, Scene, SceneObject
from stucksolver.solver.state_machine.pending_transition import PendingTransition

FACES_COS = -0.7
"""Cosine of the angle between two headings up to which vehicles face each other. Ours: within 45 degrees."""
STANDS_MPS = 0.5
"""Speed up to which the other vehicle counts as standing (m/s)."""
AHEAD_M, ASIDE_M = 60.0, 6.0
"""The other vehicle is within this distance ahead and aside (m): beyond an obstacle on each side, in the next lane."""
LEAST_S = 0.5
"""Shortest time until the next query (s)."""
BACKS_OFF = (WaitReason.YIELD, WaitReason.UNKNOWN_STOPPED)
"""Waits that a standoff can prolong for ever."""


def draw(turn: PendingTransition, scene: Scene) -> float | None:
    """Return the number of this vehicle in the present period of a standoff, in [0, 1); None without a standoff.

    It follows from the vehicle's id, the number of the intervention and the period. Without an id, the place of the ego
    takes its place, since two vehicles are never at the same one.
    """
    standstill, after_s = turn.state.standstill, turn.setup.ladder.standoff.after_s
    if standstill is None or turn.now_s - standstill.since_s < after_s:
        return None
    if not any(_faces(o) for o in scene.objects):
        return None
    under_way = turn.state.intervention
    number = turn.state.interventions + 1 if under_way is None else under_way.number
    period = int((turn.now_s - standstill.since_s) / after_s)
    return random.Random(f"{_vehicle(turn)}/{number}/{period}").random()


def back_off(turn: PendingTransition, reason: WaitReason | None = None) -> None:
    """In a standoff, put the next query off by the drawn time.

    Args:
        turn: The transition.
        reason: Reason of the legitimate wait; None after a plan that failed.
    """
    longest_s = turn.setup.ladder.standoff.back_off_s
    drawn = None if turn.state.scene is None else turn.state.scene.ego.yield_draw
    if drawn is None or longest_s <= 0.0 or (reason is not None and reason not in BACKS_OFF):
        return
    turn.pause(turn.now_s + max(drawn * longest_s, LEAST_S))


def _vehicle(turn: PendingTransition) -> str:
    if turn.setup.vehicle_id or turn.surroundings is None:
        return turn.setup.vehicle_id
    ego = turn.surroundings.ego
    return f"{ego.x_m:.0f} {ego.y_m:.0f}"


def _faces(o: SceneObject) -> bool:
    """True for a vehicle that stands ahead and faces the ego."""
    near = 0.0 < o.x_m < AHEAD_M and abs(o.y_m) < ASIDE_M
    stands = math.hypot(o.vx_mps, o.vy_mps) <= STANDS_MPS
    return o.kind in MOTOR_VEHICLES and near and stands and math.cos(o.yaw_rad) < FACES_COS
