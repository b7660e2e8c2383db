"""Whom the ego lets past: an emergency vehicle with its lights on that comes up from behind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stucksolver.stacks.driver.route_line import rejoining_length
from stucksolver.stacks.planner.passes import LONGEST_RETURN_M, Pass, Situation

EMERGENCY_LAMPS = 512 | 1024
"""The blue lights, as bits of `carla.VehicleLightState` (Special1 and Special2)."""
BEHIND_M = 100.0
LANE_M = 2.0
SLOWER = 0.6
"""While it is let past, the ego drives at this share of its speed."""
LEAST_MPS = 3.0
STRETCH_M = 40.0
"""The way aside is planned so far ahead, and on while it is needed."""
PAST_M = 8.0
"""Its rear is so far ahead of our bumper when the ego goes back."""
ROOM_BEHIND_M = 4.0
ROOM_BEHIND_S = 1.5
"""Seconds of who comes up in the lane to go back to, beside `ROOM_BEHIND_M`."""


def comes_behind(here: Situation) -> list[int]:
    """Ids of vehicles behind the ego in its lane that drive its way and are no slower."""
    bodies = here.bodies
    behind = (bodies.s < here.s_m) & (bodies.s > here.s_m - BEHIND_M) & ~bodies.is_walker
    same = (np.abs(bodies.d - here.d_m) < LANE_M) & (bodies.vs > 1.0) & (bodies.vs > here.speed_mps - 1.0)
    found: list[int] = bodies.actor_id[behind & same].tolist()
    return found


def aside(here: Situation, whom: frozenset[int]) -> Iterator[Pass]:
    """Ways into a lane beside of our direction, the right one first."""
    room = here.sides.room(here.s_m, here.s_m + STRETCH_M)
    speed = max(SLOWER * here.speed_mps, LEAST_MPS)
    for width, sign in ((room.right_same, 1.0), (room.left_same, -1.0)):
        if width > 0.0:
            offset = sign * (room.half + width / 2.0)
            beside = here.s_m + rejoining_length(offset, here.speed_mps)
            returns = beside + STRETCH_M
            back = returns + LONGEST_RETURN_M
            yield Pass(offset, here.s_m, beside, returns, back, speed, False, whom, returns)


def is_past(here: Situation, whom: frozenset[int]) -> bool:
    """Are those out of sight, or ahead of the ego by enough?"""
    bodies = here.bodies
    theirs = bodies.among(whom)
    rear = here.s_m + here.model.half_length + PAST_M
    behind = (bodies.s - bodies.along < rear) & (bodies.s > here.s_m - BEHIND_M)
    return not bool((theirs & behind).any())


def may_return(here: Situation) -> bool:
    """Is the route's lane free abreast of the ego, and does nobody come up in it?"""
    bodies, half = here.bodies, here.model.half_length
    inside = np.abs(bodies.d) - bodies.aside < here.model.half_width + 0.3
    closing = np.maximum(bodies.vs - here.speed_mps, 0.0)
    behind = here.s_m - half - (bodies.s + bodies.along)
    ahead = bodies.s - bodies.along - here.s_m - half
    near = (behind < ROOM_BEHIND_M + ROOM_BEHIND_S * closing) & (ahead < ROOM_BEHIND_M)
    return not bool((inside & near).any())
