"""Connects a CARLA vehicle and its driver with the solver: describes the ego and performs the directives."""

from __future__ import annotations

from typing import Any

import carla

from stucksolver.plan import CONTINUE, Continue, Directive, Execute, Replan, SafeStop
from stucksolver.plan.mirror import mirrored_directive
from stucksolver.scene import Status
from stucksolver_carla.drivers.behavior import DrivePoint, Driver, RouteError
from stucksolver_carla.drivers.behavior.nearby_objects import HAZARD_LAMPS
from stucksolver_carla.stack.active_directive import ActiveDirective
from stucksolver_carla.stack.alternative_routes import reachable_destination
from stucksolver_carla.stack.carla_frames import to_local, to_world
from stucksolver_carla.stack.client_interface import EgoVehicle
from stucksolver_carla.stack.front_camera import PictureSource
from stucksolver_carla.stack.ground_truth_tracker import RANGE_M
from stucksolver_carla.stack.route_after_turn import points_along
from stucksolver_carla.stack.scene_source import CarlaSceneSource

NEAR_DESTINATION_M = 100.0
"""Remaining route length below which a parallel lane of the destination is allowed (m). With so little left, the
destination's own lane may be reachable only around the block. Ours."""
DETOUR_M = 100.0
"""Additional length from which a new route counts as leading around the block (m). Ours."""
DRIVES_THROTTLE = 0.1
"""Throttle above which the driver drives, in [0, 1]. Ours."""
DRIVING_MPS = 2.0
"""Speed above which the ego no longer needs its hazard lights after the hand-back (m/s). Ours."""


class CarlaStack(CarlaSceneSource):
    """The stack of one ego with one driver. On each tick call `status`, then `StuckSolver.step`, then `perform`.

    If the status was not read on a tick, `step` has not been called. The directive in `perform` is then no renewal.
    """

    def __init__(
        self,
        vehicle: EgoVehicle,
        driver: Driver,
        carla_map: carla.Map | None = None,
        range_m: float = RANGE_M,
        camera: PictureSource | None = None,
    ) -> None:
        super().__init__(vehicle, driver, carla_map, range_m, camera)
        self._driver = driver
        self._active_directive = ActiveDirective()
        self._performed: Directive | None = None
        self._given: tuple[Directive, Directive] = (CONTINUE, CONTINUE)
        """The solver's last directive, and the same in the map's frame."""
        self._lights_before: carla.VehicleLightState | None = None
        self._drives: bool | None = None

    def status(self) -> Status:
        """Return the status, with what the driver did on the last tick."""
        return super().status().model_copy(update={"drives": self._drives})

    def perform(self, directive: Directive | None) -> Any:
        """Perform a directive with the driver. An invalid directive is replaced by a stop and reported once.

        Args:
            directive: The solver's directive; None without one on this tick. The last one is then performed until it
                expires, then its fallback, and then the driver follows its route.

        Returns:
            This tick's `carla.VehicleControl`, not applied.
        """
        self._active_directive.update(None if directive is None else self.in_map_frame(directive), self._was_read)
        self._was_read = False
        due = self._active_directive.due(*to_local(self._vehicle.get_location()), self._speed_mps)
        if due is not self._performed:
            self._performed = self._start(due)
        if self._lights_before is not None and self._is_driving():
            self._hazard_lights(False)
        control = self._driver.run_step()
        if isinstance(control, carla.VehicleControl):
            braked = control.brake > 0.0 or control.hand_brake
            self._drives = control.throttle > DRIVES_THROTTLE and not braked
        return control

    def in_map_frame(self, directive: Directive) -> Directive:
        """Return a directive of the solver in the map's frame: the same object for the same directive."""
        if directive is not self._given[0]:
            self._given = (directive, mirrored_directive(directive) if self._is_mirrored else directive)
        return self._given[1]

    def forget(self) -> None:
        """Instruct the driver again on the next tick, because it has lost its last instruction."""
        self._performed = None
        if self._lights_before is not None:
            self._vehicle.set_light_state(carla.VehicleLightState(int(self._lights_before) | HAZARD_LAMPS))

    def _start(self, directive: Directive) -> Directive:
        """Start a directive. Return it, or a stop if the driver raises an error."""
        try:
            self._instruct_driver(directive)
        except Exception as error:  # noqa: BLE001 - no error of a driver may end the control loop; the ego stops
            directive = self._active_directive.reject(f"{type(error).__name__}: {error}")
            self._driver.hold()
        return directive

    def _instruct_driver(self, directive: Directive) -> None:
        if isinstance(directive, Execute) and directive.path:
            points = [DrivePoint(*to_world(p.x_m, p.y_m), p.speed_mps) for p in directive.path]
            ignored_ids = frozenset(int(i) for i in directive.ignore)
            if directive.over_red:
                ignored_ids |= self._controls.lights_near(self._arc)
            if ignored_ids:
                self._driver.follow(points, directive.reverse, ignored_ids)
            else:
                self._driver.follow(points, directive.reverse)
        elif isinstance(directive, Execute):
            lights_on = directive.behavior.hazard_lights_on
            if lights_on is not None:
                self._hazard_lights(lights_on)
            if directive.brake_mps2 is None:
                self._driver.hold()
            else:
                self._driver.hold(directive.brake_mps2)
        elif isinstance(directive, SafeStop):
            self._hazard_lights(True)
            self._driver.hold()
        else:
            self._driver.release()
            if isinstance(directive, Replan):
                self._replan(directive)

    def _hazard_lights(self, on: bool) -> None:
        """Switch the hazard lights on, or all lights back to their previous state."""
        if on and self._lights_before is None:
            self._lights_before = self._vehicle.get_light_state()
            self._vehicle.set_light_state(carla.VehicleLightState(int(self._lights_before) | HAZARD_LAMPS))
        elif not on and self._lights_before is not None:
            self._vehicle.set_light_state(self._lights_before)
            self._lights_before = None

    def _is_driving(self) -> bool:
        """Return True if the driver follows its route again, faster than `DRIVING_MPS`."""
        return isinstance(self._performed, Continue) and self._speed_mps > DRIVING_MPS

    def _replan(self, directive: Replan) -> None:
        """Plan the route again. The present one stays without another one, or if the ego points against it."""
        end = self._driver.route[-1].waypoint.transform.location
        chosen = self._candidates.get(directive.route_start or "")
        if chosen is not None and not points_along(chosen, self._vehicle.get_transform().rotation.yaw):
            return
        start = None if chosen is None else chosen.transform.location
        left_m = self._road.destination_arc - self._arc
        origin = self._vehicle.get_location() if start is None else start
        try:
            if directive.route_start not in self._alternative_ids and left_m < NEAR_DESTINATION_M:
                reachable = reachable_destination(self._map, origin, end, max(left_m, 0.0) + DETOUR_M)
                if reachable is None:
                    return
                end = reachable
            self._driver.set_destination(end, start)
        except RouteError:
            # Without another route, the driver continues on the present one.
            return
        self.take_route()
