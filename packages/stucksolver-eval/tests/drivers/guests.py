"""Agents as users write them: one for the leaderboard, and some that do what no agent may."""

from __future__ import annotations

import json
import math
from pathlib import Path

import carla

AHEAD = 10
"""Points of the route to the one that is steered for."""
ENDS = 200
"""The step at which it has driven enough for a test."""


class ForLeaderboard:
    """Steers by GNSS and compass alone, and writes down what it was given. `setup` is given a file to write to."""

    def __init__(self, carla_host, carla_port, debug=False):
        self.steps, self.at = 0, 0

    def setup(self, path_to_conf_file):
        self.file = path_to_conf_file

    def sensors(self):
        center = {"x": 0.0, "y": 0.0, "z": 2.0, "roll": 0.0, "pitch": 0.0, "yaw": 0.0}
        camera = {"type": "sensor.camera.rgb", "id": "front", "width": 80, "height": 60, "fov": 90, **center}
        return [
            camera,
            {"type": "sensor.lidar.ray_cast", "id": "lidar", **center},
            {"type": "sensor.other.imu", "id": "imu", "sensor_tick": 0.05, **center},
            {"type": "sensor.other.gnss", "id": "gnss", "sensor_tick": 0.01, **center},
            {"type": "sensor.speedometer", "id": "speed", "reading_frequency": 20},
            {"type": "sensor.opendrive_map", "id": "map", "reading_frequency": 1},
        ]

    def set_global_plan(self, global_plan_gps, global_plan_world_coord):
        self.gps = [(place["lat"], place["lon"]) for place, _ in global_plan_gps]
        self.turns = sorted({option.name for _, option in global_plan_world_coord})

    def run_step(self, input_data, timestamp):
        self.steps += 1
        lat, lon, _ = input_data["gnss"][1]
        compass, speed = input_data["imu"][1][6], input_data["speed"][1]["speed"]
        # Meters north and east of here, on the sphere that CARLA maps flat.
        meters = [(math.radians(a - lat) * 6378137.0, math.radians(b - lon) * 6378137.0) for a, b in self.gps]
        near = range(self.at, min(self.at + 30, len(meters)))
        self.at = min(near, key=lambda k: math.hypot(*meters[k]))
        north, east = meters[min(self.at + AHEAD, len(meters) - 1)]
        turned = math.remainder(math.atan2(east, north) - compass, math.tau)
        if self.steps == ENDS:
            told = json.loads(Path(self.file).read_text(encoding="utf-8"))
            told |= {"at": self.at, "aside": meters[self.at]}
            Path(self.file).write_text(json.dumps(told), encoding="utf-8")
            raise RuntimeError("that is enough")
        if self.steps == 20:
            given = {name: getattr(data, "shape", None) for name, (_, data) in input_data.items()}
            told = {
                "given": given,
                "frames": len({f for f, _ in input_data.values()}),
                "time_s": timestamp,
                "speed": speed,
                "turns": self.turns,
                "picture": float(input_data["front"][1][..., :3].std()),
                "map": input_data["map"][1]["opendrive"][:60],
            }
            Path(self.file).write_text(json.dumps(told), encoding="utf-8")
        return carla.VehicleControl(throttle=0.5 if speed < 6.0 else 0.0, steer=max(min(0.8 * turned, 1.0), -1.0))

    def destroy(self):
        Path(self.file).with_suffix(".end").write_text(str(self.steps), encoding="utf-8")


class Nonsense:
    """Gives what is no control."""

    def __init__(self, vehicle, carla_map):
        """Nothing is needed."""

    def set_route(self, route):
        """Not looked at."""

    def run_step(self):
        return carla.VehicleControl(throttle=float("nan"))


class Breaks(Nonsense):
    """Has a fault."""

    def run_step(self):
        raise KeyError("the user's own fault")


class AsksForSonar(ForLeaderboard):
    """Wants a sensor that nobody has."""

    def sensors(self):
        return [{"type": "sensor.other.sonar", "id": "sonar"}]


class Deaf:
    """Has a step, but takes no route."""

    def run_step(self):
        return None
