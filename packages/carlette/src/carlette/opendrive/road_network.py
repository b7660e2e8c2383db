"""The road network for the server: ground, speed signs, spawn points."""

from __future__ import annotations

import math
from typing import Any, NamedTuple
from xml.etree import ElementTree

from carlette.errors import MapError
from carlette.geometry import Pose, Rotation, Vector
from carlette.opendrive.faults import explain
from carlette.opendrive.map_file import MapFile, check_opendrive
from carlette.opendrive.speed_limit_boxes import SpeedBoxes, read_speed_boxes
from carlette.opendrive.traffic_side import check_traffic_side

SPAWN_SPACING_M = 20.0
"""Distance between spawn points (m). Ours."""
SPAWN_HEIGHT_M = 0.5
"""Height of spawn points above the road (m). Ours."""
CURB_M = 0.15
"""Height of sidewalks above the road (m). Ours."""


class Ground(NamedTuple):
    """The road's surface near a point, as a plane."""

    origin: Vector
    slope_x: float
    """Rise in z for each meter of x."""
    slope_y: float
    curb_m: float = 0.0
    """Height of the walking surface above the road's (m). Sidewalks are higher."""


class RoadNetwork:
    """Wraps `carla.Map` (which cannot be pickled, so a copy builds its own from the text)."""

    def __init__(self, file: MapFile) -> None:
        """Raise `MapError` if the client's library cannot load the file as a map."""
        root = check_opendrive(file.text, file.source)
        self.file = file
        self.carla: Any = carla_library()
        self.map: Any = self._build(root)
        self.speed_boxes: SpeedBoxes = read_speed_boxes(self.carla, self.map)

    def __getstate__(self) -> MapFile:
        return self.file

    def __setstate__(self, file: MapFile) -> None:
        self.__init__(file)  # type: ignore[misc]

    def _build(self, root: ElementTree.Element) -> Any:
        source = self.file.source
        try:
            built = self.carla.Map(self.file.name, self.file.text)
            drivable = built.generate_waypoints(5.0)
        except Exception as error:  # noqa: BLE001
            # The library raises whatever its C++ code throws, such as an `IndexError` of a missing road.
            raise MapError(f"map '{source}' is rejected by the carla library ({error}): {explain(root)}") from None
        if not drivable:
            raise MapError(f"map '{source}' has no driving lane; give a map with roads to drive on")
        if not any(waypoint.lane_width > 0.0 for waypoint in drivable):
            raise MapError(f"map '{source}' has no driving lane of any width: {explain(root)}")
        check_traffic_side(root, source, drivable[0])
        return built

    def waypoint(self, point: Vector) -> Any:
        """Return the nearest waypoint of any lane type."""
        return self.map.get_waypoint(self.carla.Location(*point), True, self.carla.LaneType.Any)

    def ground(self, point: Vector) -> Ground:
        """Return the surface of the lane nearest to `point`."""
        found = self.waypoint(point)
        transform = found.transform
        location, rotation = transform.location, transform.rotation
        slope = math.tan(math.radians(rotation.pitch))
        yaw = math.radians(rotation.yaw)
        return Ground(
            Vector(location.x, location.y, location.z),
            slope * math.cos(yaw),
            slope * math.sin(yaw),
            CURB_M if found.lane_type == self.carla.LaneType.Sidewalk else 0.0,
        )

    def spawn_points(self) -> list[Pose]:
        """Return positions on driving lanes outside junctions, half a meter above the road."""
        driving = self.carla.LaneType.Driving
        sampled = self.map.generate_waypoints(SPAWN_SPACING_M)
        outside = [item for item in sampled if not item.is_junction and item.lane_type == driving]
        places = [_above(item) for item in outside or sampled]
        # The library gives no position on an arc of curvature 0.
        return [place for place in places if place.is_finite()]


def _above(waypoint: Any) -> Pose:
    location, rotation = waypoint.transform.location, waypoint.transform.rotation
    return Pose(
        Vector(location.x, location.y, location.z + SPAWN_HEIGHT_M), Rotation(rotation.pitch, rotation.yaw, 0.0)
    )


def carla_library() -> Any:
    """Return the client's module. Raises `MapError` if it is not installed."""
    try:
        import carla
    except ImportError:
        raise MapError(
            "the package 'carla' is not installed, and it has wheels for Python 3.10, 3.11 and 3.12 only; "
            "install carlette under one of them"
        ) from None
    return carla
