"""Gives way to an emergency vehicle with its lights on that comes up from behind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stucksolver_carla.drivers.behavior.route_line import rejoining_length
from stucksolver_carla.drivers.planner.pass_planner import LONGEST_RETURN_M, PassCandidate, PassContext

EMERGENCY_LAMPS = 512 | 1024
"""The blue lights, as bits of `carla.VehicleLightState` (Special1 and Special2)."""
BEHIND_M = 100.0
LANE_M = 2.0
SLOWER = 0.6
"""The ego drives at this share of its speed meanwhile."""
LEAST_MPS = 3.0
STRETCH_M = 40.0
"""The way aside is planned this far ahead, and extended while it is needed."""
PAST_M = 8.0
"""The ego returns when the vehicle's rear is this far ahead of its bumper."""
ROOM_BEHIND_M = 4.0
ROOM_BEHIND_S = 1.5
"""Time gap to traffic in the lane to return to, besides `ROOM_BEHIND_M`."""


def approaches_from_behind(here: PassContext) -> list[int]:
    """Return the ids of vehicles behind the ego in its lane, in its direction, that are no slower."""
    bodies = here.bodies
    behind = (bodies.s < here.s_m) & (bodies.s > here.s_m - BEHIND_M) & ~bodies.is_walker
    same = (np.abs(bodies.d - here.d_m) < LANE_M) & (bodies.vs > 1.0) & (bodies.vs > here.speed_mps - 1.0)
    found: list[int] = bodies.actor_id[behind & same].tolist()
    return found


def aside(here: PassContext, whom: frozenset[int]) -> Iterator[PassCandidate]:
    """Yield ways into a lane beside of our direction, the right one first."""
    room = here.sides.room(here.s_m, here.s_m + STRETCH_M)
    speed = max(SLOWER * here.speed_mps, LEAST_MPS)
    for width, sign in ((room.right_same, 1.0), (room.left_same, -1.0)):
        if width > 0.0:
            offset = sign * (room.half + width / 2.0)
            beside = here.s_m + rejoining_length(offset, here.speed_mps)
            returns = beside + STRETCH_M
            back = returns + LONGEST_RETURN_M
            yield PassCandidate(offset, here.s_m, beside, returns, back, speed, False, whom, returns)


def is_past(here: PassContext, whom: frozenset[int]) -> bool:
    """True if they are out of sight, or far enough ahead of the ego."""
    bodies = here.bodies
    theirs = bodies.among(whom)
    rear = here.s_m + here.model.half_length + PAST_M
    behind = (bodies.s - bodies.along < rear) & (bodies.s > here.s_m - BEHIND_M)
    return not bool((theirs & behind).any())


def may_return(here: PassContext) -> bool:
    """True if the route's lane is free beside the ego and nobody comes up in it."""
    bodies, half = here.bodies, here.model.half_length
    inside = np.abs(bodies.d) - bodies.aside < here.model.half_width + 0.3
    closing = np.maximum(bodies.vs - here.speed_mps, 0.0)
    behind = here.s_m - half - (bodies.s + bodies.along)
    ahead = bodies.s - bodies.along - here.s_m - half
    near = (behind < ROOM_BEHIND_M + ROOM_BEHIND_S * closing) & (ahead < ROOM_BEHIND_M)
    return not bool((inside & near).any())
