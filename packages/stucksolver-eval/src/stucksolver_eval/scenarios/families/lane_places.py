"""Positions relative to a lane, as `carla.Transform`s and `carla.Waypoint`s.

Sides are those of right-hand traffic: the right is the side of the road's edge. On roads with left-hand traffic, they
are mirrored.
"""

from __future__ import annotations

import math

import carla

from stucksolver_bridge.traffic_side import drives_on_left, inner_lane, outer_lane

MOST_LANES = 8
"""Maximum number of lanes on one side. Ours."""
SPACING_M = 1.2
"""Distance between two objects of a row across a road (m). Ours."""
MOST_EACH_SIDE = 20
"""Maximum number of objects on each side of such a row. Ours."""
FOR_VEHICLES = carla.LaneType.Driving | carla.LaneType.Parking | carla.LaneType.Biking | carla.LaneType.Stop


def offset_pose(
    waypoint: carla.Waypoint, right_m: float = 0.0, ahead_m: float = 0.0, up_m: float = 0.0, turn_deg: float = 0.0
) -> carla.Transform:
    """Return a transform offset from a waypoint to the right, ahead and up (m), and turned clockwise (degrees)."""
    at = waypoint.transform
    if drives_on_left(waypoint):
        right_m, turn_deg = -right_m, -turn_deg
    yaw = math.radians(at.rotation.yaw)
    cos, sin = math.cos(yaw), math.sin(yaw)
    place = carla.Location(
        at.location.x + ahead_m * cos - right_m * sin,
        at.location.y + ahead_m * sin + right_m * cos,
        at.location.z + up_m,
    )
    rotation = carla.Rotation(pitch=at.rotation.pitch, yaw=at.rotation.yaw + turn_deg)
    return carla.Transform(place, rotation)


def lane_of(waypoint: carla.Waypoint, kind: carla.LaneType, direction: str = "right") -> carla.Waypoint | None:
    """Return the first lane of this type in this direction across the road, or None."""
    here = waypoint
    for _ in range(MOST_LANES):
        there: carla.Waypoint | None = outer_lane(here) if direction == "right" else inner_lane(here)
        if there is None:
            return None
        if there.lane_type == kind:
            return there
        # Left and right are swapped on the other side of the road's center.
        if direction == "left" and there.lane_id * here.lane_id < 0:
            return lane_of(there, kind, "right")
        here = there
    return None


def edge_m(waypoint: carla.Waypoint, direction: str = "right") -> float:
    """Return the distance from a waypoint to the outer edge of the outermost lane for vehicles on that side (m)."""
    here, edge = waypoint, waypoint.lane_width / 2.0
    for _ in range(MOST_LANES):
        there = outer_lane(here) if direction == "right" else inner_lane(here)
        if there is None or there.lane_type not in _FOR_VEHICLES or there.lane_id * waypoint.lane_id < 0:
            break
        here, edge = there, edge + there.lane_width
    return edge


_FOR_VEHICLES = (carla.LaneType.Driving, carla.LaneType.Parking, carla.LaneType.Biking, carla.LaneType.Stop)


def side_driving_lane(waypoint: carla.Waypoint, side: str) -> carla.Waypoint | None:
    """Return the adjacent driving lane of the same direction on that side, or None."""
    there: carla.Waypoint | None = inner_lane(waypoint) if side == "left" else outer_lane(waypoint)
    if there is None or there.lane_id * waypoint.lane_id < 0 or there.lane_type != carla.LaneType.Driving:
        return None
    return there


def door_to_lane(waypoint: carla.Waypoint, parked: str = "right") -> carla.VehicleDoor:
    """Return the front door through which a vehicle that is parked on that side opens into the lane."""
    return carla.VehicleDoor.FL if (parked == "right") != drives_on_left(waypoint) else carla.VehicleDoor.FR


def upstream(waypoint: carla.Waypoint, distance_m: float, step_m: float = 5.0) -> carla.Waypoint:
    """Return the waypoint `distance_m` back, as straight as possible through junctions, or where the lanes start."""
    here, gone = waypoint, 0.0
    while gone < distance_m:
        step = min(step_m, distance_m - gone)
        before = here.previous(step)
        if not before:
            return here
        here, gone = min(before, key=lambda item: abs(turn_deg(item, here))), gone + step
    return here


def run_of_lane(start: carla.Waypoint, length_m: float, step_m: float = 2.0) -> list[carla.Waypoint]:
    """Return waypoints along a lane from `start`, as straight as possible at forks; fewer if the lane ends."""
    found, gone = [start], 0.0
    while gone < length_m:
        after = found[-1].next(step_m)
        if not after:
            break
        found.append(after[0] if len(after) == 1 else min(after, key=lambda item: abs(way_turn_deg(found[-1], item))))
        gone += step_m
    return found


def way_turn_deg(before: carla.Waypoint, first: carla.Waypoint) -> float:
    """Return the change of heading (degrees, clockwise) from a waypoint to the end of the junction lane at `first`."""
    here = first
    for _ in range(60):
        after = here.next(1.0)
        if not here.is_junction or not after:
            break
        here = after[0]
    return turn_deg(before, here)


def turn_deg(before: carla.Waypoint, after: carla.Waypoint) -> float:
    """Return the change of heading in [-180, 180] degrees, clockwise."""
    return math.remainder(after.transform.rotation.yaw - before.transform.rotation.yaw, 360.0)


def row_across(carla_map: carla.Map, here: carla.Waypoint) -> list[carla.Transform]:
    """Return the poses of a row of objects across a road, over the width that vehicles can drive.

    If the waypoint `here` is in a junction, the row is perpendicular to the road that its lane leads into.
    """
    # Positions are mirrored in left-hand traffic, so the turn is, too.
    turn = -way_turn_deg(here, here) if drives_on_left(here) else way_turn_deg(here, here)
    places = [_across(here, k * SPACING_M, turn) for k in range(-MOST_EACH_SIDE, MOST_EACH_SIDE + 1)]
    on_road = [k for k, place in enumerate(places) if carla_map.get_waypoint(place.location, False, FOR_VEHICLES)]
    # Lanes that diverge in a junction leave gaps between them, which are paved too.
    return places[on_road[0] : on_road[-1] + 1]


def _across(waypoint: carla.Waypoint, aside_m: float, turn_deg: float) -> carla.Transform:
    """Return an object's pose `aside_m` to the right of a waypoint, on a road that turns by `turn_deg` clockwise."""
    square = math.radians(turn_deg)
    along_m, right_m = -aside_m * math.sin(square), aside_m * math.cos(square)
    return offset_pose(waypoint, right_m, along_m, turn_deg=turn_deg + 90.0)
