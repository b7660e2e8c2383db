"""The views of a ride on the page: a live top view and the front camera's pictures."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from stucksolver.plan import CONTINUE, Directive
from stucksolver_carla.stack.front_camera import FrontCamera
from stucksolver_eval.results.run_log import ActorRole, RunLogFrame
from stucksolver_eval.routes.route_line import RouteLine
from stucksolver_eval.run_log.logger import RunLogger
from stucksolver_eval.run_log.map_view import map_view
from stucksolver_passenger.gateway import PassengerGateway

if TYPE_CHECKING:
    import carla

FRAME_EVERY_S = 0.1
"""Interval between frames (s). Ours."""
PICTURE_EVERY_S = 0.2
"""Interval between pictures (s). Ours."""


class LiveView:
    """Sends a frame of the top view ten times per second.

    Positions are in meters, y to the left of x, yaw in degrees.
    """

    def __init__(self, desk: PassengerGateway, vehicle: str, world: carla.World, hero: carla.Vehicle) -> None:
        self._desk, self._vehicle, self._world = desk, vehicle, world
        self._logger = RunLogger(world, hero, self._role, FRAME_EVERY_S)

    def show_scenery(self, carla_map: carla.Map, line: RouteLine) -> None:
        """Send the static scenery once: the road along the route."""
        places = [(w.transform.location.x, -w.transform.location.y) for w in line.waypoints]
        scenery = map_view(carla_map, places).model_dump(mode="json")
        self._desk.show_scenery(self._vehicle, {**scenery, "route": [[round(x, 2), round(y, 2)] for x, y in places]})

    def tick(self, time_s: float, speed_mps: float, directive: Directive | None) -> None:
        """Send the next frame, if one is due. `time_s` counts from the ride's start."""
        self._logger.directive(time_s, directive or CONTINUE)
        self._logger.frame(time_s, speed_mps)
        if self._logger.frames:
            self._desk.show_view(self._vehicle, self._packed(self._logger.frames.pop()))
        self._logger.events.clear()

    def _packed(self, frame: RunLogFrame) -> dict[str, Any]:
        """Return a complete frame, not a difference, because a page may miss frames."""
        actors = self._logger.actors
        return {
            "time": frame.time_s,
            "speed": frame.speed_mps,
            "actors": [
                [
                    index,
                    actors[index].kind,
                    actors[index].role,
                    actors[index].length_m,
                    actors[index].width_m,
                    x,
                    y,
                    yaw,
                ]
                for index, x, y, yaw in frame.poses
            ],
            "lights": frame.lights,
            "path": frame.path,
        }

    def _role(self, actor_id: str) -> ActorRole:
        actor = self._world.get_actor(int(actor_id))
        role = "" if actor is None else actor.attributes.get("role_name", "")
        if role == "background":
            return "traffic"
        return "scenario" if role == "scenario" else "prop"


class Pictures:
    """Sends the front camera's picture five times per second, in a separate thread because encoding is slow."""

    def __init__(self, show: Callable[[bytes], None], hero: carla.Vehicle) -> None:
        self._show = show
        self._camera = FrontCamera(hero, period_s=PICTURE_EVERY_S)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._send, name="passenger-pictures", daemon=True)
        self._thread.start()

    def _send(self) -> None:
        last = b""
        while not self._over.wait(PICTURE_EVERY_S):
            image = self._camera.image()
            if image is not None and image.jpeg != last:
                last = image.jpeg
                self._show(last)

    def close(self) -> None:
        """Stop the thread and remove the camera."""
        self._over.set()
        self._thread.join()
        self._camera.close()
