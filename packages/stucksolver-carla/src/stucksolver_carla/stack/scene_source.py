"""Describes a CARLA vehicle on its route to the solver: status, surroundings and scene."""

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
from stucksolver.scene.mirror import mirrored_scene, mirrored_surroundings
from stucksolver.scene.scene_builder import build_scene
from stucksolver_carla.drivers.behavior import RouteHolder
from stucksolver_carla.stack.alternative_routes import junction_alternatives
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
from stucksolver_carla.stack.route_after_turn import route_after_turning
from stucksolver_carla.stack.route_road import SPACING_M, RouteRoad
from stucksolver_carla.stack.route_side import is_left_hand_route
from stucksolver_carla.stack.traffic_controls import RouteTrafficControls

TRACK_PERIOD_S = 0.5
"""Time between two updates of the tracker while only the status is read (s). Ours."""
SLICE_LENGTH_M = 60.0
"""Distance driven after which the road geometry is sliced again (m). Ours."""
CANDIDATES_M = (20.0, 40.0, 70.0, 110.0)
"""Distances ahead of the ego at which a new route may start (m). Ours."""
DESTINATION_M = 5.0
"""Remaining route length at which the ego counts as arrived (m). Ours."""
START_SEARCH_M = 30.0
"""Length of a new route, from its start, on which the ego is searched (m). Ours."""


class CarlaSceneSource:
    """Describes one ego to the solver, and applies and sets nothing.

    For a `carla.Vehicle` the data are ground truth from the client (`perception` is `privileged`). For a vehicle with
    sensor-based perception (its attribute `perceiver`), the data come from that perception. `driver` must already have
    its route. With a `camera`, its latest image is in the scene.

    All parts of the stack use the map's frame. On a route with left-hand traffic, `surroundings` and `scene` are
    mirrored as their last step, and `CarlaStack.in_map_frame` mirrors directives back.
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
        self._route_holder = driver
        self._world: WorldSource = vehicle.get_world()
        self._map = self._world.get_map() if carla_map is None else carla_map
        self._range_m = range_m
        self._camera = camera
        self._perception: EgoPerceptionSource | None = getattr(vehicle, "perceiver", None)
        self.perception = "privileged" if self._perception is None else self._perception.perception
        self._tracker: TrackedObjectSource = (
            Tracker(self._world, vehicle.id, range_m) if self._perception is None else self._perception.tracker()
        )
        self._tracked_s = -math.inf
        self._was_read = False
        """True if the status or the surroundings were read since the last tick."""
        self._behaviors: tuple[AvailableBehavior, ...] = describe(tuple(REGISTRY))
        box = vehicle.bounding_box
        self._size = (2 * float(box.extent.x), 2 * float(box.extent.y))
        # Without the driver's own value, the default acceleration is assumed.
        defaults = VehicleLimits()
        acceleration_mps2 = float(getattr(driver, "acceleration_mps2", defaults.comfort_acceleration_mps2))
        self._limits = defaults.model_copy(update={"comfort_acceleration_mps2": acceleration_mps2})
        self._candidates: dict[str, Any] = {}
        self._alternative_ids: set[str] = set()
        """The candidates whose route lengths are in the scene."""
        self._progress_m = 0.0
        """Length of route covered, without repeated stretches (m). It continues when the route is planned again."""
        self.take_route()

    def take_route(self) -> None:
        """Read the road along the driver's route. Call this again when the route changes."""
        route = self._route_holder.route
        self._is_mirrored = is_left_hand_route(self._map, route)
        progress_m = self._progress_m
        self._road = RouteRoad(self._map, route)
        actors = self._world.get_actors()
        lights, signs = list(actors.filter("*traffic_light*")), list(actors.filter("*traffic.stop*"))
        self._controls = RouteTrafficControls(lights, self._road, signs)
        self._geometry: RoadGeometry | None = None
        self._geometry_arc = 0.0
        # The ego is at the route's start or before it. The rest is excluded, because the route may return here later.
        last = int((self._road.start_arc + START_SEARCH_M) / SPACING_M)
        self._arc = self._road.arc_of(*to_local(self._vehicle.get_location()), 0, last)
        self._station = int(self._arc / SPACING_M)
        self._best_arc = self._arc
        self._progress_offset_m = progress_m - self._road.new_ground(self._arc)
        self._progress_m = progress_m

    @property
    def route_length_m(self) -> float:
        """Length of the route from the ego to the destination (m)."""
        return self._road.destination_arc - self._arc

    # ---- read by the solver

    def status(self) -> Status:
        """Return the status. Cheap: a projection on the route, and twice per second an update of the tracker."""
        self._was_read = True
        snapshot = self._world.get_snapshot()
        now = float(snapshot.timestamp.elapsed_seconds)
        location = self._vehicle.get_location()
        if now - self._tracked_s >= TRACK_PERIOD_S:
            self._tracked_s = now
            self._tracker.watch(footprint(self._vehicle), now)
        self._advance(*to_local(location))
        remaining_m = self._road.destination_arc - self._best_arc
        return Status(
            time_s=now,
            speed_mps=self._speed_mps,
            progress_m=self._progress_m,
            pushes=self._tracker.pushes,
            at_destination=remaining_m < DESTINATION_M,
        )

    def surroundings(self) -> Surroundings:
        """Return the surroundings at this tick; mirrored on a route with left-hand traffic."""
        surroundings = self._surroundings()
        return mirrored_surroundings(surroundings) if self._is_mirrored else surroundings

    def _surroundings(self) -> Surroundings:
        """Return the surroundings at this tick in the map's frame."""
        self._was_read = True
        snapshot = self._world.get_snapshot()
        now = float(snapshot.timestamp.elapsed_seconds)
        ego = self._ego()
        self._tracker.read_lights(now)
        objects = self._tracker.update(footprint(self._vehicle), now)
        road = self._road_slice()
        front = self._arc + self._size[0] / 2
        return Surroundings(
            frame=int(snapshot.frame),
            time_s=now,
            age_s=0.0 if self._perception is None else self._perception.age_s(now),
            sensor_faults=() if self._perception is None else self._perception.why_blind,
            ego=ego,
            objects=objects,
            controls=self._controls.ahead(front),
            sight=self._lines.of_lanes(ego, self._arc, objects),
            road=road,
        )

    def scene(self, surroundings: Surroundings | None = None) -> Scene:
        """Return the scene for a reasoner, from the solver's `surroundings`; None takes those of this tick."""
        if surroundings is None:
            surroundings = self._surroundings()
        elif surroundings.road.mirrored:
            surroundings = mirrored_surroundings(surroundings)
        view = FrenetScene(surroundings)
        scene = build_scene(
            view,
            self.status(),
            self._behaviors,
            waypoints=self._waypoints(view),
            route_command=self._route_command(),
            image=None if self._camera is None else self._camera.image(),
            signs=() if self._perception is None else self._perception.signs,
        )
        return mirrored_scene(scene) if self._is_mirrored else scene

    # ---- parts

    @property
    def _speed_mps(self) -> float:
        velocity = self._vehicle.get_velocity()
        return math.hypot(velocity.x, velocity.y)

    def _advance(self, x: float, y: float) -> None:
        """Update the position on the route, and the progress, except while the ego pushes an object."""
        before_m = self._road.new_ground(self._best_arc)
        self._arc = self._locate(x, y)
        self._best_arc = max(self._best_arc, self._arc)
        covered_m = self._road.new_ground(self._best_arc)
        if self._tracker.pushes:
            self._progress_offset_m -= covered_m - before_m
        self._progress_m = self._progress_offset_m + covered_m

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
            position_sd_m=None if self._perception is None else self._perception.position_sd_m,
        )

    def _road_slice(self) -> RoadGeometry:
        if self._geometry is None or abs(self._arc - self._geometry_arc) > SLICE_LENGTH_M:
            limit = float(self._vehicle.get_speed_limit()) / 3.6
            self._geometry = self._road.slice(self._arc, limit if limit > 0 else None)
            self._geometry_arc = self._arc
            frame = road_frame(self._geometry)
            self._lines: LaneSightSource = (
                SightLines(frame, self._range_m) if self._perception is None else self._perception.sight_lines(frame)
            )
        return self._geometry

    def _waypoints(self, view: FrenetScene) -> tuple[CandidateWaypoint, ...]:
        """Return candidates for the start of a new route: ahead in each lane of the ego's direction, and elsewhere."""
        candidates = []
        height_m = self._vehicle.get_location().z
        for lane in view.frame.lanes:
            if lane.strip.kind is not LaneKind.DRIVING or lane.strip.direction is not LaneDirection.SAME:
                continue
            for ahead in CANDIDATES_M:
                s = view.ego_s + ahead
                if not lane.covers(s, s):
                    continue
                x, y, _ = (float(v[0]) for v in view.frame.to_local(np.array([s]), np.array([lane.at(s)[1]])))
                waypoint = self._map.get_waypoint(carla.Location(*to_world(x, y), height_m))
                if waypoint is not None:
                    name = f"{lane.strip.id}+{ahead:.0f}"
                    self._candidates[name] = waypoint
                    candidates.append(_candidate(name, lane.strip.id, x, y, ahead, view))
        return (*candidates, *self._alternative_waypoints(view))

    def _alternative_waypoints(self, view: FrenetScene) -> list[CandidateWaypoint]:
        """Return candidates with their route lengths: other connections through this junction, or the oncoming lane.

        The oncoming lane is a candidate only outside junctions.
        """
        end = self._route_holder.route[-1].waypoint.transform.location
        candidates = []
        alternatives = list(junction_alternatives(self._map, self._road, self._arc, view.ego, view.objects, end))
        turned_route = route_after_turning(self._map, self._road, self._arc, view.ego, end)
        for k, alternative in enumerate(alternatives if turned_route is None else [*alternatives, turned_route]):
            name = f"{alternative.turn}-elsewhere{k}"
            self._candidates[name] = alternative.waypoint
            self._alternative_ids.add(name)
            x, y = to_local(alternative.waypoint.transform.location)
            candidate = _candidate(name, name, x, y, round(alternative.distance_m, 1), view)
            length_m = alternative.route_length_m
            reaches = {"reaches_destination": length_m is not None, "route_length_m": length_m and round(length_m, 1)}
            candidates.append(candidate.model_copy(update=reaches))
        return candidates

    def _route_command(self) -> str | None:
        route = self._route_holder.route
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
