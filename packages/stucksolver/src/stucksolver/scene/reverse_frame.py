"""Mirrors the surroundings for an ego that backs up: the reference line is reversed, and the ego faces its own rear.

In that frame a maneuver in reverse is an ordinary one, so every check for driving forward applies to it.
"""

from __future__ import annotations

import math
from functools import lru_cache

from stucksolver.scene.frenet import RoadGeometryByKey, road_frame
from stucksolver.scene.road import LaneStrip, RoadGeometry, Zone
from stucksolver.scene.surroundings import LaneSight, Surroundings


def backwards(surroundings: Surroundings) -> Surroundings:
    """Return the same tick, looking back along the route. Arc lengths and offsets change sign.

    Traffic controls are left out, because they bind traffic in the other direction.
    """
    ego = surroundings.ego
    turned = ego.model_copy(
        update={"yaw_rad": math.remainder(ego.yaw_rad + math.pi, math.tau), "speed_mps": -ego.speed_mps}
    )
    sight = tuple(LaneSight(lane_id=x.lane_id, ahead_m=x.behind_m, behind_m=x.ahead_m) for x in surroundings.sight)
    road = _road(RoadGeometryByKey(surroundings.road))
    return surroundings.model_copy(update={"ego": turned, "sight": sight, "controls": (), "road": road})


@lru_cache(maxsize=4)
def _road(keyed: RoadGeometryByKey) -> RoadGeometry:
    road = keyed.road
    end_m = road_frame(road).end_m
    count = len(road.reference)
    zones = tuple(Zone(kind=z.kind, start_m=-z.end_m, end_m=-z.start_m) for z in road.zones)
    return road.model_copy(
        update={
            "key": f"{road.key} backwards",
            "reference": road.reference[::-1],
            "lanes": tuple(_strip(lane, count) for lane in road.lanes),
            "zones": zones[::-1],
            "route_start_m": -end_m,
            "destination_m": None,
        }
    )


def _strip(lane: LaneStrip, count: int) -> LaneStrip:
    return lane.model_copy(
        update={
            "start": count - lane.start - len(lane.offset_m),
            "offset_m": tuple(-offset for offset in lane.offset_m[::-1]),
            "width_m": lane.width_m[::-1],
            "line": lane.line[::-1],
        }
    )
