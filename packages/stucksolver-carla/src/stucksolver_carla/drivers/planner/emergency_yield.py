"""Yields to an emergency vehicle with its lights on that approaches from behind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stucksolver_carla.drivers.behavior.route_line import rejoining_length
from stucksolver_carla.drivers.planner.pass_planner import LONGEST_RETURN_M, PassCandidate, PassContext

EMERGENCY_LAMPS = 512 | 1024
"""The blue lights, as bits of `carla.VehicleLightState` (Special1 and Special2)."""
BEHIND_M = 100.0
"""Range behind the ego (m). Ours."""
LANE_M = 2.0
"""Maximum lateral offset of a vehicle in the ego's lane (m). Ours."""
SPEED_SHARE = 0.6
"""Share of its speed at which the ego drives while it yields. Ours."""
MIN_MPS = 3.0
"""Minimum speed of the ego while it yields (m/s). Ours."""
HOLD_M = 40.0
"""Length in the adjacent lane for which the yield is planned; it is extended as long as needed (m). Ours."""
PAST_M = 8.0
"""Distance from the ego's front bumper to the emergency vehicle's rear at which the ego returns (m). Ours."""
GAP_M = 4.0
"""Required gap in the lane for the return: the constant part (m). Ours."""
GAP_S = 1.5
"""Required gap to traffic from behind for the return: the part that grows with the closing speed (s). Ours."""


def approaches_from_behind(context: PassContext) -> list[int]:
    """Return the ids of vehicles behind the ego in its lane that drive in its direction and are not slower."""
    bodies = context.bodies
    is_behind = (bodies.s < context.s_m) & (bodies.s > context.s_m - BEHIND_M) & ~bodies.is_walker
    is_following = (np.abs(bodies.d - context.d_m) < LANE_M) & (bodies.vs > 1.0) & (bodies.vs > context.speed_mps - 1.0)
    ids: list[int] = bodies.actor_id[is_behind & is_following].tolist()
    return ids


def yield_candidates(context: PassContext, emergency_ids: frozenset[int]) -> Iterator[PassCandidate]:
    """Yield paths into an adjacent lane of the ego's direction, the one toward the road's edge first."""
    widths = context.sides.narrowest(context.s_m, context.s_m + HOLD_M)
    speed = max(SPEED_SHARE * context.speed_mps, MIN_MPS)
    for sign in (context.sides.edge_side, -context.sides.edge_side):
        width = widths.right_same if sign > 0.0 else widths.left_same
        if width > 0.0:
            offset = sign * (widths.half + width / 2.0)
            beside_m = context.s_m + rejoining_length(offset, context.speed_mps)
            returns_m = beside_m + HOLD_M
            back_m = returns_m + LONGEST_RETURN_M
            yield PassCandidate(
                offset, context.s_m, beside_m, returns_m, back_m, speed, False, emergency_ids, returns_m
            )


def is_past(context: PassContext, emergency_ids: frozenset[int]) -> bool:
    """Return True if the emergency vehicles are far enough ahead of the ego, or no longer detected."""
    bodies = context.bodies
    is_emergency = bodies.has_id_in(emergency_ids)
    rear_limit = context.s_m + context.model.half_length + PAST_M
    is_behind = (bodies.s - bodies.along < rear_limit) & (bodies.s > context.s_m - BEHIND_M)
    return not bool((is_emergency & is_behind).any())


def may_return(context: PassContext) -> bool:
    """Return True if the route's lane is free next to the ego, and free of fast rear traffic."""
    bodies, half = context.bodies, context.model.half_length
    is_in_lane = np.abs(bodies.d) - bodies.aside < context.model.half_width + 0.3
    closing = np.maximum(bodies.vs - context.speed_mps, 0.0)
    is_behind = context.s_m - half - (bodies.s + bodies.along)
    ahead = bodies.s - bodies.along - context.s_m - half
    is_near = (is_behind < GAP_M + GAP_S * closing) & (ahead < GAP_M)
    return not bool((is_in_lane & is_near).any())
