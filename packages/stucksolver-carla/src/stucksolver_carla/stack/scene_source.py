"""A CARLA vehicle on its route in the solver's form: status, surroundings and scene."""

from __future__ import annotations

import math
from typing import Any

import carla
import numpy as np

from stucksolver.plan.behaviors import REGISTRY, describe
from stucksolver.scene import (
    AvailableBehavior,
    CandidateWaypoint,
    EgoState,
    LaneDirection,
    LaneKind,
    RoadGeometry,
    Scene,
    Status,
    Surroundings,
    VehicleLimits,
)
from stucksolver.scene.frenet import road_frame
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.scene_builder import build_scene
from stucksolver_carla.drivers.behavior import RouteHolder
from stucksolver_carla.stack.alternative_routes import other_ways
from stucksolver_carla.stack.carla_frames import to_local, to_world, yaw_to_local
from stucksolver_carla.stack.client_interface import (
    EgoPerceptionSource,
    EgoVehicle,
    LaneSightSource,
    TrackedObjectSource,
    WorldSource,
)
from stucksolver_carla.stack.contact import footprint
from stucksolver_carla.stack.front_camera import PictureSource
from stucksolver_carla.stack.ground_truth_tracker import RANGE_M, Tracker
from stucksolver_carla.stack.line_of_sight import SightLines
from stucksolver_carla.stack.route_after_turn import way_back
from stucksolver_carla.stack.route_road import SPACING_M, RouteRoad
from stucksolver_carla.stack.traffic_controls import RouteTrafficControls

TRACK_EVERY_S = 0.5
EPISODE_REACH_M = 60.0
"""After this much progress the road is read again: a new episode begins."""
CANDIDATES_M = (20.0, 40.0, 70.0, 110.0)
DESTINATION_M = 5.0
STARTS_WITHIN_M = 30.0


class CarlaSceneSource:
    """Describes one ego to the solver; it applies, ticks and sets nothing.

    For a `carla.Vehicle` the data are ground truth from the client (`perception` is `privileged`). A vehicle with its
    own perception (`SensedVehicle.perceiver`) is described by its sensors. `driver` must have its route when this is
    made. With a `camera`, its latest image is in the scene.
    """

    def __init__(
        self,
        vehicle: EgoVehicle,
        driver: RouteHolder,
        carla_map: carla.Map | None = None,
        range_m: float = RANGE_M,
        camera: PictureSource | None = None,
    ) -> None:
        self._vehicle = vehicle
        self._follows = driver
        self._world: WorldSource = vehicle.get_world()
        self._map = self._world.get_map() if carla_map is None else carla_map
        self._range_m = range_m
        self._camera = camera
        self._eyes: EgoPerceptionSource | None = getattr(vehicle, "perceiver", None)
        self.perception = "privileged" if self._eyes is None else self._eyes.perception
        self._tracker: TrackedObjectSource = (
            Tracker(self._world, vehicle.id, range_m) if self._eyes is None else self._eyes.tracker()
        )
        self._tracked_s = -math.inf
        self._asked = False
        """True if anything was asked since the last tick."""
        self._behaviors: tuple[AvailableBehavior, ...] = describe(tuple(REGISTRY))
        box = vehicle.bounding_box
        self._size = (2 * float(box.extent.x), 2 * float(box.extent.y))
        # A driver that does not state its acceleration is assumed to use the usual one.
        usual = VehicleLimits()
        quickest = float(getattr(driver, "acceleration_mps2", usual.comfort_acceleration_mps2))
        self._limits = usual.model_copy(update={"comfort_acceleration_mps2": quickest})
        self._candidates: dict[str, Any] = {}
        self._elsewhere: set[str] = set()
        """The candidates whose route length was given to the reasoner."""
        self._progress_m = 0.0
        """New ground covered so far (m); continues when the route is planned again."""
        self.take_route()

    def take_route(self) -> None:
        """Read the road along the driver's route; repeated whenever the route changes."""
        route = self._follows.route
        progress_m = self._progress_m
        self._road = RouteRoad(self._map, route)
        actors = self._world.get_actors()
        lights, signs = list(actors.filter("*traffic_light*")), list(actors.filter("*traffic.stop*"))
        self._controls = RouteTrafficControls(lights, self._road, signs)
        self._geometry: RoadGeometry | None = None
        self._geometry_arc = 0.0
        # The ego is at the route's start or before it; a route that passes here again must not confuse that.
        last = int((self._road.start_arc + STARTS_WITHIN_M) / SPACING_M)
        self._arc = self._road.arc_of(*to_local(self._vehicle.get_location()), 0, last)
        self._station = int(self._arc / SPACING_M)
        self._best_arc = self._arc
        self._progress_offset_m = progress_m - self._road.new_ground(self._arc)
        self._progress_m = progress_m

    @property
    def route_length_m(self) -> float:
        """Return the length of the route from the ego to the destination (m)."""
        return self._road.destination_arc - self._arc

    # ---- for the solver

    def status(self) -> Status:
        """Return the status. Cheap: a projection on the route; twice a second the tracker looks around as well."""
        self._asked = True
        snapshot = self._world.get_snapshot()
        now = float(snapshot.timestamp.elapsed_seconds)
        place = self._vehicle.get_location()
        if now - self._tracked_s >= TRACK_EVERY_S:
            self._tracked_s = now
            self._tracker.watch(footprint(self._vehicle), now)
        self._advance(*to_local(place))
        left = self._road.destination_arc - self._best_arc
        return Status(
            time_s=now,
            speed_mps=self._speed_mps,
            progress_m=self._progress_m,
            pushes=self._tracker.pushes,
            at_destination=left < DESTINATION_M,
        )

    def surroundings(self) -> Surroundings:
        """Return the world as it is at this tick."""
        self._asked = True
        snapshot = self._world.get_snapshot()
        now = float(snapshot.timestamp.elapsed_seconds)
        ego = self._ego()
        self._tracker.read_lights(now)
        objects = self._tracker.update(footprint(self._vehicle), now)
        road = self._episode_road()
        front = self._arc + self._size[0] / 2
        return Surroundings(
            frame=int(snapshot.frame),
            time_s=now,
            age_s=0.0 if self._eyes is None else self._eyes.age_s(now),
            sensor_faults=() if self._eyes is None else self._eyes.why_blind,
            ego=ego,
            objects=objects,
            controls=self._controls.ahead(front),
            sight=self._lines.of_lanes(ego, self._arc, objects),
            road=road,
        )

    def scene(self, seen: Surroundings | None = None) -> Scene:
        """Return the scene for a reasoner, of the given surroundings or else of this tick's."""
        view = FrenetScene(self.surroundings() if seen is None else seen)
        return build_scene(
            view,
            self.status(),
            self._behaviors,
            waypoints=self._waypoints(view),
            route_command=self._route_command(),
            image=None if self._camera is None else self._camera.image(),
            signs=() if self._eyes is None else self._eyes.signs,
        )

    # ---- parts

    @property
    def _speed_mps(self) -> float:
        velocity = self._vehicle.get_velocity()
        return math.hypot(velocity.x, velocity.y)

    def _advance(self, x: float, y: float) -> None:
        """Note the place on the route. Ground covered while pushing something does not count."""
        before = self._road.new_ground(self._best_arc)
        self._arc = self._locate(x, y)
        self._best_arc = max(self._best_arc, self._arc)
        covered = self._road.new_ground(self._best_arc)
        if self._tracker.pushes:
            self._progress_offset_m -= covered - before
        self._progress_m = self._progress_offset_m + covered

    def _locate(self, x: float, y: float) -> float:
        arc = self._road.arc_of(x, y, self._station - 5, self._station + 15)
        self._station = max(0, int(arc / SPACING_M))
        return arc

    def _ego(self) -> EgoState:
        transform, velocity = self._vehicle.get_transform(), self._vehicle.get_velocity()
        x, y = to_local(transform.location)
        yaw = yaw_to_local(transform.rotation.yaw)
        return EgoState(
            x_m=x,
            y_m=y,
            yaw_rad=yaw,
            speed_mps=velocity.x * math.cos(yaw) - velocity.y * math.sin(yaw),
            length_m=self._size[0],
            width_m=self._size[1],
            limits=self._limits,
            position_sd_m=None if self._eyes is None else self._eyes.position_sd_m,
        )

    def _episode_road(self) -> RoadGeometry:
        if self._geometry is None or abs(self._arc - self._geometry_arc) > EPISODE_REACH_M:
            limit = float(self._vehicle.get_speed_limit()) / 3.6
            self._geometry = self._road.slice(self._arc, limit if limit > 0 else None)
            self._geometry_arc = self._arc
            frame = road_frame(self._geometry)
            self._lines: LaneSightSource = (
                SightLines(frame, self._range_m) if self._eyes is None else self._eyes.sight_lines(frame)
            )
        return self._geometry

    def _waypoints(self, view: FrenetScene) -> tuple[CandidateWaypoint, ...]:
        """Return places ahead, in each lane of our direction, from which the route could be planned again."""
        found = []
        height = self._vehicle.get_location().z
        for lane in view.frame.lanes:
            if lane.strip.kind is not LaneKind.DRIVING or lane.strip.direction is not LaneDirection.SAME:
                continue
            for ahead in CANDIDATES_M:
                s = view.ego_s + ahead
                if not lane.covers(s, s):
                    continue
                x, y, _ = (float(v[0]) for v in view.frame.to_local(np.array([s]), np.array([lane.at(s)[1]])))
                where = self._map.get_waypoint(carla.Location(*to_world(x, y), height))
                if where is not None:
                    name = f"{lane.strip.id}+{ahead:.0f}"
                    self._candidates[name] = where
                    found.append(_candidate(name, lane.strip.id, x, y, ahead, view))
        return (*found, *self._waypoints_elsewhere(view))

    def _waypoints_elsewhere(self, view: FrenetScene) -> list[CandidateWaypoint]:
        """Return places on the other ways through this junction, or on the way back from a road outside junctions.

        The route length from these places is known.
        """
        end = self._follows.route[-1].waypoint.transform.location
        found = []
        ways = list(other_ways(self._map, self._road, self._arc, view.ego, view.objects, end))
        back = way_back(self._map, self._road, self._arc, view.ego, end)
        for k, way in enumerate(ways if back is None else [*ways, back]):
            name = f"{way.turn}-elsewhere{k}"
            self._candidates[name] = way.waypoint
            self._elsewhere.add(name)
            x, y = to_local(way.waypoint.transform.location)
            candidate = _candidate(name, name, x, y, round(way.distance_m, 1), view)
            length_m = way.route_length_m
            told = {"reaches_destination": length_m is not None, "route_length_m": length_m and round(length_m, 1)}
            found.append(candidate.model_copy(update=told))
        return found

    def _route_command(self) -> str | None:
        route = self._follows.route
        index = int(self._arc - self._road.start_arc)
        return route[index].command if 0 <= index < len(route) else None


def _candidate(name: str, lane_id: str, x: float, y: float, ahead: float, view: FrenetScene) -> CandidateWaypoint:
    c, n = math.cos(view.ego.yaw_rad), math.sin(view.ego.yaw_rad)
    dx, dy = x - view.ego.x_m, y - view.ego.y_m
    return CandidateWaypoint(
        id=name,
        lane_id=lane_id,
        x_m=round(dx * c + dy * n, 2),
        y_m=round(dy * c - dx * n, 2),
        distance_m=ahead,
    )
