"""A ride in a toy world with a real server: what a browser, or many clients, connect to."""

from __future__ import annotations

import io
import threading
import time
from pathlib import Path

import stucksolver_eval.report
from stucksolver import StuckSolver
from stucksolver.interpreter import find_reader
from stucksolver_passenger.gateway import PassengerGateway
from stucksolver_passenger.server.process import PassengerServer
from worlds import World

DRAWING = Path(stucksolver_eval.report.__file__).parent / "assets"
VIEW_TICKS, PICTURE_TICKS = 2, 4
READER = find_reader()
"""One for all rides: it takes a while to load, which it does now."""
READER.read("hello", "")


def scenery():
    """A straight road with two lanes."""

    def along(y):
        return [[0.0, y], [400.0, y]]

    lanes = [{"kind": "driving", "left": along(y + 1.75), "right": along(y - 1.75)} for y in (0.0, 3.5)]
    marks = [{"kind": "broken", "color": "yellow", "points": along(1.75)}]
    return {"name": "test", "lanes": lanes, "markings": marks, "route": along(0.0)}


def picture() -> bytes:
    """A gray one."""
    from PIL import Image

    file = io.BytesIO()
    Image.new("RGB", (800, 450), (120, 130, 140)).save(file, "JPEG")
    return file.getvalue()


class Riding:
    """Drives a world in a thread of its own, `tempo` times as fast as the clock, until it is left."""

    def __init__(self, server: PassengerServer, vehicle: str, world: World, policy, tempo: float = 4.0) -> None:
        self.world, self._vehicle, self.tempo = world, vehicle, tempo
        self._desk = PassengerGateway(server.address)
        settings = {"clock": "wall", "ladder": policy, "on_event": self._desk.ear(vehicle), "reader": READER}
        self._solver = StuckSolver(world.scene, **settings)
        self._seat = self._desk.add(vehicle, self._solver, f"Car {vehicle}")
        self._desk.show_scenery(vehicle, scenery())
        self._picture = picture()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._drive, daemon=True)
        self.lateness_s: list[float] = []

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join()
        self._desk.leave(self._vehicle)
        self._desk.close()
        self._solver.close()

    def end(self):
        """The ride is over; the page stays."""
        self._over.set()
        self._thread.join()
        self._seat.end()

    def _drive(self):
        due, tick = time.monotonic(), 0
        while not self._over.is_set():
            time.sleep(max(due - time.monotonic(), 0.0))
            self.lateness_s.append(time.monotonic() - due)
            due = max(due + self.world.dt / self.tempo, time.monotonic())
            directive = self._solver.step(self.world.status(), self.world.surroundings)
            self._seat.tick(self.world.status(), self.world.scene)
            self.world.drive(directive)
            tick += 1
            if tick % VIEW_TICKS == 0:
                self._desk.show_view(self._vehicle, self._view())
            if tick % PICTURE_TICKS == 0:
                self._desk.show_picture(self._vehicle, self._picture)

    def _view(self):
        ego = self.world.ego()
        others = [
            [i, "car", "traffic", o.length_m, o.width_m, o.x_m, o.y_m, 0] for i, o in enumerate(self.world.objects, 1)
        ]
        own = [0, "car", "ego", ego.length_m, ego.width_m, ego.x_m, ego.y_m, ego.yaw_rad * 57.3]
        return {"time": self.world.time_s, "speed": ego.speed_mps, "actors": [own, *others], "lights": [], "path": []}
