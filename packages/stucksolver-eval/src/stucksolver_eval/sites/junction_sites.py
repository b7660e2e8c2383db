"""Sites at junctions in towns and between them. The lengths are ours."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import carla

from stucksolver_eval.routes import Parameter
from stucksolver_eval.sites.lane_walk import Path, Town, approach, follow, lane_to_right
from stucksolver_eval.sites.movements import ArmSide, Control, JunctionMovement, Turn, arm, straight
from stucksolver_eval.sites.site import Site

_TRIGGER_BEFORE_M = 38
"""Distance of the trigger before the junction (m)."""
_START_BEFORE_M = 75
"""Distance of the route's start before the junction (m)."""
_END_AFTER_M = 95
"""Distance of the route's end after the junction (m)."""
_FLOW_BEFORE_M = 75
"""Distance of a flow's start before the junction (m)."""
_FLOW_AFTER_M = 55
"""Distance of a flow's end after the junction (m)."""
_BICYCLES_BEFORE_M = 40
"""Distance of a bicycle flow's start before the junction (m)."""
_BICYCLES_AFTER_M = 40
"""Distance of a bicycle flow's end after the junction (m)."""
_NEAR_M = 3
"""Distance of marks from the junction (m). It is short, so that the route through the junction is unambiguous."""

LIT: frozenset[Control] = frozenset({"light"})
UNLIT: frozenset[Control] = frozenset({"stop", "yield", "none"})
SIGNED: frozenset[Control] = frozenset({"stop", "yield"})
LEFT_TURNS: frozenset[Turn] = frozenset({"left"})
RIGHT_TURNS: frozenset[Turn] = frozenset({"right"})
TURNS: frozenset[Turn] = frozenset({"left", "right"})
STRAIGHT: frozenset[Turn] = frozenset({"straight"})
ALL_WAYS: frozenset[Turn] = frozenset({"left", "straight", "right"})
OPPOSITE: frozenset[ArmSide] = frozenset({"opposite"})
FROM_LEFT: frozenset[ArmSide] = frozenset({"left"})

Ways = list[JunctionMovement]
Places = Mapping[str, Any]
Extra = Callable[[JunctionMovement, Ways], Iterator[tuple[Places, Mapping[str, Parameter]]]]
"""Yields the parameters that follow from the site, once for each variant of the scenario there."""


def _nothing(mine: JunctionMovement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    yield {}, {}


@dataclass(frozen=True)
class JunctionSites:
    """Finds all movements through junctions that satisfy a type's requirements."""

    turns: frozenset[Turn] = frozenset({"left", "right"})
    controls: frozenset[Control] = frozenset({"light", "stop", "yield", "none"})
    arms: int = 0
    """Exact number of roads; 0 is any number."""
    from_sides: frozenset[ArmSide] = frozenset()
    """Sides from which traffic must be able to go straight on."""
    rightmost: bool = False
    """True for the lane at the curb only, next to a sidewalk."""
    trigger_m: int = _TRIGGER_BEFORE_M
    """Distance from the trigger to the junction."""
    extra: Extra = field(default=_nothing)

    def __call__(self, town: Town, ways: Ways) -> Iterator[Site]:
        with_turns = {way.junction_id for way in ways if way.turn != "straight"}
        for mine in ways:
            if mine.turn not in self.turns or mine.control not in self.controls or mine.junction_id not in with_turns:
                continue
            if self.arms and mine.arms != self.arms:
                continue
            if not all(straight(arm(mine, side, ways)) for side in self.from_sides):
                continue
            if self.rightmost and not lane_to_right(mine.entry, carla.LaneType.Sidewalk):
                continue
            for number, (positions, fixed) in enumerate(self.extra(mine, ways)):
                site = site_at(mine, self.trigger_m)
                yield replace(site, place=f"{site.place}#{number}", positions=positions, fixed=fixed)


def site_at(mine: JunctionMovement, trigger_m: int = _TRIGGER_BEFORE_M, end_m: int = _END_AFTER_M) -> Site:
    """Return the site of a route through a junction."""
    before = approach(mine.entry, max(_START_BEFORE_M, trigger_m + _START_BEFORE_M - _TRIGGER_BEFORE_M))
    trigger = before[-trigger_m]
    inside = follow(mine.inside, 80, through=(mine.inside.road_id,))
    inside = tuple(item for item in inside if item.road_id == mine.inside.road_id)
    after = follow(mine.exit, end_m)
    after = tuple(item for item in after if item.road_id == mine.exit.road_id)
    marks = (before[0], before[-_NEAR_M], after[_NEAR_M], after[-1])
    group = f"junction {mine.junction_id}"
    return Site(mine.town, group, mine.key, (*before, *inside, *after), marks, trigger)


def _to_exit_lane(mine: JunctionMovement, of: Ways) -> Ways:
    """Return the movements straight on into the lane that the ego turns into, or its neighbor."""
    return [
        item
        for item in straight(of)
        if item.exit.road_id == mine.exit.road_id and item.exit.lane_id == mine.exit.lane_id
    ]


def enter_flow(mine: JunctionMovement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    """Yield positions of a flow from the left on the road that the ego turns right into."""
    for other in _to_exit_lane(mine, arm(mine, "left", ways)):
        yield flow(other), {}


def oncoming_flow(mine: JunctionMovement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    """Yield positions of a flow from the opposite arm, straight through."""
    for other in straight(arm(mine, "opposite", ways)):
        yield flow(other), {}


def crossing_flow(mine: JunctionMovement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    """Yield positions of a flow from the left across the ego's path.

    The second flow, from the right, follows from it.
    """
    for other in straight(arm(mine, "left", ways)):
        yield flow(other), {"direction": {"value": "right"}}


def flow(other: JunctionMovement, before_m: int = _FLOW_BEFORE_M, after_m: int = _FLOW_AFTER_M) -> Places:
    """Return the start and end of a flow along a movement."""
    start = approach(other.entry, before_m)[0]
    return {"start_actor_flow": start, "end_actor_flow": follow(other.exit, after_m)[-1]}


def bicycles(mine: JunctionMovement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    """Yield bicycle lanes: to the ego's right for a right turn, the oncoming one for a left turn."""
    sources = [mine] if mine.turn == "right" else straight(arm(mine, "opposite", ways))
    for other in sources:
        start = lane_to_right(approach(other.entry, _BICYCLES_BEFORE_M)[0], carla.LaneType.Biking)
        at_junction = lane_to_right(other.entry, carla.LaneType.Biking)
        beyond = _beyond_junction(at_junction) if at_junction is not None else ()
        if start is not None and len(beyond) > _BICYCLES_AFTER_M:
            yield {"start_actor_flow": start, "end_actor_flow": beyond[_BICYCLES_AFTER_M]}, {}


def _beyond_junction(bicycle_lane: Any) -> Path:
    """Return the lane's continuation after the junction; empty if it ends there."""
    path = follow(bicycle_lane, 120)
    inside = [index for index, item in enumerate(path) if item.is_junction]
    return path[inside[-1] + 1 :] if inside else ()


def joined(mine: JunctionMovement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    """Yield a site if oncoming cars can turn right into the same lane that the ego turns left into."""
    leave = (mine.exit.road_id, mine.exit.lane_id)
    if any((item.exit.road_id, item.exit.lane_id) == leave for item in arm(mine, "opposite", ways)):
        yield {}, {}


def direction_of(*sides: ArmSide) -> Extra:
    """Return an extra that adds `direction`: each of `sides` whose traffic conflicts with the ego's path."""

    def extra(mine: JunctionMovement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
        for side in sides:
            if mine.turn in _MEETS[side] and straight(arm(mine, side, ways)):
                yield {}, {"direction": {"value": side}}

    return extra


_MEETS: Mapping[ArmSide, frozenset[Turn]] = {
    "opposite": frozenset({"left"}),
    "left": frozenset({"left", "straight", "right"}),
    "right": frozenset({"left", "straight"}),
}
"""Turns whose path is crossed or joined by traffic that goes straight on from a side."""
