"""Second heads of traffic lights, for drivers at the stop line who cannot see the first.

They are beyond the line, off all lanes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from threading import Lock
from weakref import WeakKeyDictionary

from carlette.camera.environment.road_furniture import BEYOND_BOX_M
from carlette.camera.models.mesh import Point
from carlette.camera.models.traffic_lights import REPEATER_HEAD, heads
from carlette.geometry import Vector
from carlette.opendrive.map_file import check_opendrive
from carlette.opendrive.road_network import RoadNetwork
from carlette.opendrive.signals import LIGHT_TYPE, Signal, read_signals

EYE_BACK_M, EYE_UP_M = 3.7, 1.6
"""Position of a front camera relative to the stop line (m), if the car's nose is two meters before the line. Ours."""
WIDEST_TAN, STEEPEST_TAN = math.tan(math.radians(38.0)), math.tan(math.radians(24.0))
"""Tangents of the angles within a picture of 800x450 pixels and 90 degrees, with a margin to its edge. Ours."""
LANE_M = 3.5
"""Width of a lane, for the positions of the outermost cameras (m)."""
NEAREST_M = 7.0
"""Smallest distance of a second post from the camera (m). Ours."""
FARTHEST_M = 60
"""Largest distance of a second post from the camera (m). Ours."""
OFF_LANE_M = 0.9
"""Smallest distance of a second post from a lane's edge (m). Ours."""
LATERALS_M = (1.2, 2.5, 4.0, 6.0, 9.0)
"""Lateral distances of a second post from the governed lanes (m), in the order of the search.

The search tries the right side first, then the left, then straight ahead of the lanes. Ours.
"""

_finding = Lock()
_found: WeakKeyDictionary[RoadNetwork, list[Point | None]] = WeakKeyDictionary()


def repeaters_of(roads: RoadNetwork) -> list[Point | None]:
    """Return the foot of each light's second post in its actor's frame (m), or None where no second post is needed."""
    with _finding:
        found = _found.get(roads)
        if found is None:
            root = check_opendrive(roads.file.text, roads.file.name)
            lights = [signal for signal in read_signals(roads, root) if signal.type == LIGHT_TYPE]
            found = _found[roads] = [_repeater(roads, light) for light in lights]
        return found


def eyes(signal: Signal) -> list[Point]:
    """Return the front cameras of the first cars in the outermost governed lanes, in the light's frame."""
    center, half = signal.box.center, signal.box.extent.x
    aside = max(half - LANE_M / 2, 0.0)
    y = center.y - BEYOND_BOX_M + EYE_BACK_M
    return [(center.x + shift, y, center.z + EYE_UP_M) for shift in ((aside, -aside) if aside else (0.0,))]


def is_in_sight(eye: Point, head: Point) -> bool:
    """True if a camera that looks along the lane shows a head well within its picture."""
    ahead = eye[1] - head[1]
    aside, up = abs(head[0] - eye[0]), abs(head[2] - eye[2])
    return ahead > 0.0 and aside <= WIDEST_TAN * ahead and up <= STEEPEST_TAN * math.hypot(ahead, aside)


def _repeater(roads: RoadNetwork, signal: Signal) -> Point | None:
    cameras = eyes(signal)
    present = heads(round(signal.box.center.x, 1))
    if all(any(is_in_sight(eye, head) for head in present) for eye in cameras):
        return None
    for x, y in _candidates(signal):
        foot = signal.pose.apply(Vector(x, y, signal.box.center.z))
        if all(is_in_sight(eye, (x, y, REPEATER_HEAD[2])) for eye in cameras) and _is_off_lanes(roads, foot):
            ground = roads.ground(foot)
            rise = (foot.x - ground.origin.x) * ground.slope_x + (foot.y - ground.origin.y) * ground.slope_y
            return x, y, ground.origin.z + rise - signal.pose.location.z
    return None


def _candidates(signal: Signal) -> Iterator[tuple[float, float]]:
    center, half = signal.box.center, signal.box.extent.x
    sides = [center.x + half + lateral for lateral in LATERALS_M]
    sides += [center.x - half - lateral for lateral in LATERALS_M]
    eye_y = center.y - BEYOND_BOX_M + EYE_BACK_M
    for step, x in itertools.product(range(math.ceil(FARTHEST_M - NEAREST_M)), [*sides, center.x]):
        yield x, eye_y - NEAREST_M - step


def _is_off_lanes(roads: RoadNetwork, place: Vector) -> bool:
    lane = roads.map.get_waypoint(roads.carla.Location(*place), True, roads.carla.LaneType.Driving)
    middle = lane.transform.location
    return bool(math.hypot(place.x - middle.x, place.y - middle.y) > lane.lane_width / 2 + OFF_LANE_M)
