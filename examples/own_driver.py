"""Your own agent in an evaluation: follows the route with pure pursuit, and stops behind whatever is ahead.

    stucksolver evaluate --suite dev --routes 1242 --driver examples.own_driver:PurePursuit --recovery search --out own

StuckSolver drives its plans itself. While no plan runs, the agent provides the control.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import carla

SPEED_MPS = 7.0
GAP_M = 8.0
WHEELBASE_M = 2.9
LOCK_RAD = 1.2


class PurePursuit:
    """Ignores lights, signs and junctions."""

    def __init__(self, vehicle: Any, carla_map: Any) -> None:
        self.vehicle = vehicle

    def set_route(self, route: Sequence[Any]) -> None:
        self.points, self.at = [p.waypoint.transform.location for p in route], 0

    def run_step(self) -> Any:
        here, velocity = self.vehicle.get_transform(), self.vehicle.get_velocity()
        speed = math.hypot(velocity.x, velocity.y)
        near = self.points[self.at : self.at + 40]
        self.at += min(range(len(near)), key=lambda k: near[k].distance(here.location))
        ahead_m, left_m = self.seen(here, self.points[min(self.at + 4 + int(speed / 2), len(self.points) - 1)])
        curvature = 2 * left_m / max(ahead_m**2 + left_m**2, 1.0)
        wanted = min(SPEED_MPS, math.sqrt(4 * max(self.free_m(here) - GAP_M, 0.0)))
        pedal = max(min(0.6 * (wanted - speed), 0.7), -1.0)
        steer = -math.atan(curvature * WHEELBASE_M) / LOCK_RAD
        return carla.VehicleControl(throttle=max(pedal, 0.0), steer=steer, brake=max(-pedal, 0.0))

    def free_m(self, here: Any) -> float:
        others = (o for o in self.vehicle.get_world().get_actors() if o.id != self.vehicle.id and "." in o.type_id)
        seen = [
            self.seen(here, o.get_location()) for o in others if o.type_id.startswith(("vehicle", "walker", "static"))
        ]
        return min((ahead for ahead, left in seen if ahead > 0 and abs(left) < 1.8), default=100.0)

    @staticmethod
    def seen(here: Any, there: Any) -> tuple[float, float]:
        """Position of `there` in the vehicle frame: (ahead, to the left), in meters."""
        to, yaw = there - here.location, math.radians(here.rotation.yaw)
        return to.x * math.cos(yaw) + to.y * math.sin(yaw), to.x * math.sin(yaw) - to.y * math.cos(yaw)
