"""A CARLA vehicle with a driver: describes itself to the solver and performs its directives."""

from __future__ import annotations

from typing import Any

import carla

from stucksolver.plan import Continue, Directive, Execute, Replan, SafeStop
from stucksolver_carla.drivers.behavior import DrivePoint, Driver, RouteError
from stucksolver_carla.drivers.behavior.nearby_objects import HAZARD_LAMPS
from stucksolver_carla.stack.active_directive import ActiveDirective
from stucksolver_carla.stack.alternative_routes import destination_beside
from stucksolver_carla.stack.carla_frames import to_local, to_world
from stucksolver_carla.stack.client_interface import EgoVehicle
from stucksolver_carla.stack.front_camera import PictureSource
from stucksolver_carla.stack.ground_truth_tracker import RANGE_M
from stucksolver_carla.stack.route_after_turn import faces
from stucksolver_carla.stack.scene_source import CarlaSceneSource

NEAR_DESTINATION_M = 100.0
"""With this little of the route left, a lane beside it may lead back only round the block."""
DETOUR_M = 100.0
"""A new route that is longer than the rest by this much goes round the block."""
ON_ITS_WAY_MPS = 2.0


class CarlaStack(CarlaSceneSource):
    """One driver, one ego. On each tick call `status`, then `StuckSolver.step`, then `perform`.

    If nothing is asked of it on a tick, nobody has called `step`; what `perform` gets then is not a renewal.
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
        self._orders = ActiveDirective()
        self._performed: Directive | None = None
        self._lights_before: carla.VehicleLightState | None = None

    def perform(self, directive: Directive | None) -> Any:
        """Have the driver perform a directive.

        What cannot be performed is replaced by standing still and reported once.

        Args:
            directive: The solver's directive. None if there is none on this tick: the last one is then performed until
                it expires, then its fallback, and then the driver follows its route.

        Returns:
            This tick's `carla.VehicleControl`, not applied.
        """
        self._orders.hear(directive, self._asked)
        self._asked = False
        due = self._orders.due(*to_local(self._vehicle.get_location()), self._speed_mps)
        if due is not self._performed:
            self._performed = self._begin(due)
        if self._lights_before is not None and self._on_its_way():
            self._hazard_lights(False)
        return self._driver.run_step()

    def forget(self) -> None:
        """Tell the driver on the next tick again what it is doing, because it has lost that."""
        self._performed = None
        if self._lights_before is not None:
            self._vehicle.set_light_state(carla.VehicleLightState(int(self._lights_before) | HAZARD_LAMPS))

    def _begin(self, directive: Directive) -> Directive:
        """Return what is begun: the directive, or standing still. No exception gets into the control loop."""
        try:
            self._tell(directive)
        except Exception as error:  # noqa: BLE001 - a driver's own fault, of whatever type
            directive = self._orders.refuse(f"{type(error).__name__}: {error}")
            self._driver.hold()
        return directive

    def _tell(self, directive: Directive) -> None:
        if isinstance(directive, Execute) and directive.path:
            points = [DrivePoint(*to_world(p.x_m, p.y_m), p.speed_mps) for p in directive.path]
            unheeded = frozenset(int(i) for i in directive.ignore)
            if directive.over_red:
                unheeded |= self._controls.lights_near(self._arc)
            if unheeded:
                self._driver.follow(points, directive.reverse, unheeded)
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
        """Switch them on, or back to what they were before."""
        if on and self._lights_before is None:
            self._lights_before = self._vehicle.get_light_state()
            self._vehicle.set_light_state(carla.VehicleLightState(int(self._lights_before) | HAZARD_LAMPS))
        elif not on and self._lights_before is not None:
            self._vehicle.set_light_state(self._lights_before)
            self._lights_before = None

    def _on_its_way(self) -> bool:
        """True if it drives by itself again, so that nobody needs a warning any more."""
        return isinstance(self._performed, Continue) and self._speed_mps > ON_ITS_WAY_MPS

    def _replan(self, directive: Replan) -> None:
        """Plan the route again. The present one stays if there is no other, or if the vehicle faces the other way."""
        end = self._driver.route[-1].waypoint.transform.location
        chosen = self._candidates.get(directive.route_start or "")
        if chosen is not None and not faces(chosen, self._vehicle.get_transform().rotation.yaw):
            return
        start = None if chosen is None else chosen.transform.location
        left_m = self._road.destination_arc - self._arc
        begin = self._vehicle.get_location() if start is None else start
        try:
            if directive.route_start not in self._elsewhere and left_m < NEAR_DESTINATION_M:
                near = destination_beside(self._map, begin, end, max(left_m, 0.0) + DETOUR_M)
                if near is None:
                    return
                end = near
            self._driver.set_destination(end, start)
        except RouteError:
            return
        self.take_route()
