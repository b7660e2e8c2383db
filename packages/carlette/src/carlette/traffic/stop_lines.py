"""Stop lines of lanes: the lane points at traffic lights and stop signs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from carlette.geometry import Floats
from carlette.traffic.lane_graph import TrafficLaneGraph
from carlette.traffic.lane_point_grid import Ints
from carlette.world.actor import ActorKind
from carlette.world.fork import shared
from carlette.world.world import World


@shared
@dataclass(frozen=True, eq=False)
class StopLines:
    """Traffic controls at each lane point that require a stop; constant within an episode."""

    light: Ints
    """Index of the traffic light; -1 = none."""
    sign: Ints
    """1 where a stop sign applies."""


def stop_lines(world: World, graph: TrafficLaneGraph) -> StopLines:
    """Return the stop lines of lights and signs: a governed lane passes the center of the trigger box."""
    light = np.full(len(graph.place), -1)
    sign = np.zeros(len(graph.place), np.int64)
    for actor in world.actors.values():
        if actor.kind is ActorKind.LIGHT or (actor.kind is ActorKind.SIGN and actor.type_id == "traffic.stop"):
            pose = world.pose(actor)
            middle = np.array(pose.apply(actor.box.center))
            yaw = np.radians(pose.rotation.yaw)
            points = _governed(graph, middle, np.array((np.cos(yaw), np.sin(yaw))), actor.box.extent.x)
            if actor.kind is ActorKind.LIGHT:
                light[points] = actor.index
            else:
                sign[points] = 1
    return StopLines(light, sign)


def _governed(graph: TrafficLaneGraph, middle: Floats, across: Floats, half_m: float) -> Ints:
    """Return the nearest point of each lane that passes through the box.

    The x axis of the box runs across the lanes.
    """
    _, points = graph.grid.candidates(middle[None], half_m + 2.0)
    gap = graph.place[points] - middle
    aside = np.abs(gap[:, :2] @ across)
    along = gap[:, 0] * across[1] - gap[:, 1] * across[0]
    # A lane crosses the box from its back to its front. The sign of the box's axis does not matter.
    straight = np.abs(graph.ahead[points] @ across) < 0.5
    heading = graph.ahead[points] @ np.array((across[1], -across[0]))
    inside = (aside <= half_m) & (np.abs(along) < 2.5) & (np.abs(gap[:, 2]) < 3.0) & straight & (heading > 0.5)
    points, along = points[inside], np.abs(along[inside])
    best: dict[int, tuple[float, int]] = {}
    for lane, off, point in zip(graph.lane[points].tolist(), along.tolist(), points.tolist(), strict=True):
        best[lane] = min(best.get(lane, (np.inf, -1)), (off, point))
    return np.array([point for _, point in best.values()], np.int64)
