"""Sites at junctions in towns and between them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import carla

from stucksolver_eval.routes import Parameter
from stucksolver_eval.suites.movements import Control, Movement, Side, Turn, arm, straight
from stucksolver_eval.suites.site import Site
from stucksolver_eval.suites.walk import Path, approach, beside, follow

_TRIGGER_BEFORE_M, _START_BEFORE_M, _END_AFTER_M = 38, 75, 95
_FLOW_BEFORE_M, _FLOW_AFTER_M = 75, 55
_BICYCLES_BEFORE_M, _BICYCLES_AFTER_M = 40, 40
_NEAR_M = 3
"""Marks lie this close to the junction, so that the route through it cannot be mistaken."""

Ways = list[Movement]
Places = Mapping[str, Any]
Extra = Callable[[Movement, Ways], Iterator[tuple[Places, Mapping[str, Parameter]]]]
"""What the place settles of the scenario's parameters: none, one or several ways to play it there."""


def _nothing(mine: Movement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    yield {}, {}


@dataclass(frozen=True)
class Through:
    """What a type needs of a way through a junction."""

    turns: frozenset[Turn] = frozenset({"left", "right"})
    controls: frozenset[Control] = frozenset({"light", "stop", "yield", "none"})
    arms: int = 0
    """Exactly so many roads; 0 = any number."""
    from_sides: frozenset[Side] = frozenset()
    """Somebody must be able to come from there and go straight on."""
    rightmost: bool = False
    """Only from the lane at the kerb, beside a sidewalk."""
    trigger_m: int = _TRIGGER_BEFORE_M
    """From the trigger to the junction."""
    extra: Extra = field(default=_nothing)


def sites(need: Through, ways: Ways) -> Iterator[Site]:
    """All ways through junctions that fit; `ways` are those of one map."""
    with_turns = {one.junction_id for one in ways if one.turn != "straight"}
    for mine in ways:
        if mine.turn not in need.turns or mine.control not in need.controls or mine.junction_id not in with_turns:
            continue
        if need.arms and mine.arms != need.arms:
            continue
        if not all(straight(arm(mine, side, ways)) for side in need.from_sides):
            continue
        if need.rightmost and not beside(mine.entry, carla.LaneType.Sidewalk):
            continue
        for number, (positions, fixed) in enumerate(need.extra(mine, ways)):
            site = site_at(mine, need.trigger_m)
            yield replace(site, place=f"{site.place}#{number}", positions=positions, fixed=fixed)


def site_at(mine: Movement, trigger_m: int = _TRIGGER_BEFORE_M, end_m: int = _END_AFTER_M) -> Site:
    """A route through a junction, without anything special."""
    before = approach(mine.entry, max(_START_BEFORE_M, trigger_m + _START_BEFORE_M - _TRIGGER_BEFORE_M))
    trigger = before[-trigger_m]
    inside = follow(mine.inside, 80, through=(mine.inside.road_id,))
    inside = tuple(one for one in inside if one.road_id == mine.inside.road_id)
    after = follow(mine.exit, end_m)
    after = tuple(one for one in after if one.road_id == mine.exit.road_id)
    marks = (before[0], before[-_NEAR_M], after[_NEAR_M], after[-1])
    group = f"junction {mine.junction_id}"
    return Site(mine.town, group, mine.key, (*before, *inside, *after), marks, trigger)


def _to_exit_lane(mine: Movement, of: Ways) -> Ways:
    """Those who drive straight on into the lane that the ego turns into, or its neighbour."""
    return [
        one for one in straight(of) if one.exit.road_id == mine.exit.road_id and one.exit.lane_id == mine.exit.lane_id
    ]


def _enter_flow(mine: Movement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    """Cars from the left on the road that the ego turns right into."""
    for other in _to_exit_lane(mine, arm(mine, "left", ways)):
        yield flow(other), {}


def _oncoming_flow(mine: Movement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    for other in straight(arm(mine, "opposite", ways)):
        yield flow(other), {}


def _crossing_flow(mine: Movement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    """Cars from the left that cross the ego's way; the second flow, from the right, follows from it."""
    for other in straight(arm(mine, "left", ways)):
        yield flow(other), {"direction": {"value": "right"}}


def flow(other: Movement, before_m: int = _FLOW_BEFORE_M, after_m: int = _FLOW_AFTER_M) -> Places:
    """Where a flow along somebody's way begins and ends."""
    start = approach(other.entry, before_m)[0]
    return {"start_actor_flow": start, "end_actor_flow": follow(other.exit, after_m)[-1]}


def _bicycles(mine: Movement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    """On the lane to the ego's right where it turns right; on the oncoming one where it turns left."""
    sources = [mine] if mine.turn == "right" else straight(arm(mine, "opposite", ways))
    for other in sources:
        start = beside(approach(other.entry, _BICYCLES_BEFORE_M)[0], carla.LaneType.Biking)
        at_junction = beside(other.entry, carla.LaneType.Biking)
        beyond = _beyond_junction(at_junction) if at_junction is not None else ()
        if start is not None and len(beyond) > _BICYCLES_AFTER_M:
            yield {"start_actor_flow": start, "end_actor_flow": beyond[_BICYCLES_AFTER_M]}, {}


def _beyond_junction(bicycle_lane: Any) -> Path:
    """The lane as it goes on after the junction; nothing where it ends there."""
    path = follow(bicycle_lane, 120)
    inside = [index for index, one in enumerate(path) if one.is_junction]
    return path[inside[-1] + 1 :] if inside else ()


def _joined(mine: Movement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
    """Oncoming cars can turn right into the very lane that the ego turns left into."""
    leave = (mine.exit.road_id, mine.exit.lane_id)
    if any((one.exit.road_id, one.exit.lane_id) == leave for one in arm(mine, "opposite", ways)):
        yield {}, {}


def _direction(*sides: Side) -> Extra:
    def extra(mine: Movement, ways: Ways) -> Iterator[tuple[Places, Mapping[str, Parameter]]]:
        for side in sides:
            if mine.turn in _MEETS[side] and straight(arm(mine, side, ways)):
                yield {}, {"direction": {"value": side}}

    return extra


_MEETS: Mapping[Side, frozenset[Turn]] = {
    "opposite": frozenset({"left"}),
    "left": frozenset({"left", "straight", "right"}),
    "right": frozenset({"left", "straight"}),
}
"""Whose way is crossed or joined by somebody who goes straight on from a side; nobody else's."""


_LIT: frozenset[Control] = frozenset({"light"})
_UNLIT: frozenset[Control] = frozenset({"stop", "yield", "none"})
_SIGNED: frozenset[Control] = frozenset({"stop", "yield"})
_LEFT: frozenset[Turn] = frozenset({"left"})
_RIGHT: frozenset[Turn] = frozenset({"right"})
_TURNS: frozenset[Turn] = frozenset({"left", "right"})
_ALL: frozenset[Turn] = frozenset({"left", "straight", "right"})
_OPPOSITE: frozenset[Side] = frozenset({"opposite"})
_FROM_LEFT: frozenset[Side] = frozenset({"left"})

NEEDS: Mapping[str, Through] = {
    "BlockedIntersection": Through(_ALL),
    "CrossingBicycleFlow": Through(_TURNS, extra=_bicycles),
    "EnterActorFlow": Through(_RIGHT, _SIGNED, extra=_enter_flow),
    "InterurbanActorFlow": Through(_LEFT, frozenset({"none"}), arms=3, extra=_oncoming_flow),
    "InterurbanAdvancedActorFlow": Through(_LEFT, _SIGNED, arms=3, extra=_crossing_flow),
    "NonSignalizedJunctionLeftTurn": Through(_LEFT, _UNLIT, from_sides=_OPPOSITE),
    "NonSignalizedJunctionLeftTurnEnterFlow": Through(_LEFT, _UNLIT, extra=_joined),
    "NonSignalizedJunctionRightTurn": Through(_RIGHT, _UNLIT, from_sides=_FROM_LEFT),
    "OppositeVehicleRunningRedLight": Through(_ALL, _LIT, arms=4, extra=_direction("opposite", "left", "right")),
    "OppositeVehicleTakingPriority": Through(_ALL, _UNLIT, extra=_direction("right", "left")),
    "PedestrianCrossing": Through(_ALL, rightmost=True),
    "SignalizedJunctionLeftTurn": Through(_LEFT, _LIT, from_sides=_OPPOSITE),
    "SignalizedJunctionLeftTurnEnterFlow": Through(_LEFT, _LIT, extra=_joined),
    "SignalizedJunctionRightTurn": Through(_RIGHT, _LIT, from_sides=_FROM_LEFT),
    "T_Junction": Through(_TURNS, arms=3),
    "VanillaNonSignalizedTurn": Through(_TURNS, frozenset({"yield", "none"})),
    "VanillaNonSignalizedTurnEncounterStopsign": Through(_TURNS, frozenset({"stop"})),
    # Near enough to pass in the 5 s that the light stays green.
    "VanillaSignalizedTurnEncounterGreenLight": Through(_TURNS, _LIT, trigger_m=20),
    "VanillaSignalizedTurnEncounterRedLight": Through(_TURNS, _LIT),
    "VehicleTurningRoute": Through(_TURNS),
    "VehicleTurningRoutePedestrian": Through(_TURNS, rightmost=True),
}
"""Scenario type to what it needs."""
