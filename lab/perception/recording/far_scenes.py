"""Records synthetic scenes for the far detector: vehicles 25 to 225 m ahead, both directions, any light and weather.

```
python -m lab.perception.recording.far_scenes --out DIR --drives 96 --seed 1 --jobs 16
```

With `--queued` a low car is stopped close ahead of the ego. The camera then sees the upper part of others over
its roof.

A drive is one town in one weather. Each scene places the ego and its surroundings anew, and takes two images half a
second apart, to measure the benefit of a second image. The recordings have the usual format, without LiDAR points.
Their camera records only the rows that training cuts out, which is several times faster than whole images. In `time_s`,
scenes are `SCENE_S` apart and their two images `LOOK_S`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import carla
import numpy as np

from lab.perception.recording.far_scene_poses import AWAY_M, ActorPose, Places
from lab.perception.recording.ground_truth import TruthReader, ego_pose
from lab.perception.recording.recording_sensors import INSTANCE_CAMERA, MountedSensor, encoded, instance_ids
from lab.perception.recording.staged_scenes import (
    CLIENT_LIMIT_S,
    draw_blueprint,
    drawn_weather,
    options,
    record_all,
    spawn_away,
)
from stucksolver_carla.client_connection import connect
from stucksolver_eval.simulator_server import carlette_server, set_synchronous
from stucksolver_perception.camera.horizon_strip import STRIP_ROWS, horizon_row
from stucksolver_perception.carla.sensor_mounting import camera_setup
from stucksolver_perception.measurements import LidarSweep
from stucksolver_perception.recording import Recorded, RecordingWriter
from stucksolver_perception.rig import Rig, load_rig

TOWNS = ("interurban", "motorway", "Town04", "Town01", "Town02", "Town10HD")
SCENE_S = 10.0
"""Time between two scenes (s)."""
LOOK_S = 0.5
"""Time between the two images of a scene (s)."""
STEP_S = 0.05
"""Step of the simulation (s)."""
EVERY_TICK = 0.0
"""Period of a camera that takes an image in every tick (s)."""
VEHICLES = 16
"""Number of vehicles of a drive. Ours."""
TWO_WHEELERS = 4
"""Number of two-wheelers of a drive. Ours."""
WALKERS = 4
"""Number of pedestrians of a drive. Ours."""
EMPTY_SHARE = 0.12
"""Share of scenes without actors. Ours; the detector learns from them that the road is not a car."""
CROWDS = (1, 2, 3, 4, 6, 8, 11, 15)
"""Largest numbers of vehicles in a scene. Ours; many vehicles hide each other."""
LIGHTS = carla.VehicleLightState
LIT = int(LIGHTS.Position | LIGHTS.LowBeam)
JPEG_QUALITY = 97
"""Quality of the JPEG images (0 to 100). Ours.

It is higher than in drives, and without chroma subsampling: far cars have few pixels, and the vehicle uses raw images.
"""
MARGIN_ROWS = 24
"""Rows above and below the strip, so that training can cut strips at other heights (`far_data.MARGIN_ROWS`)."""
QUEUED_M = (4.0, 12.0)
"""Range of the distance from the ego to the car ahead, between their bumpers (m). Ours."""
LEAD_HEIGHT_M = (1.35, 1.56)
"""Range of that car's height (m): below the lens."""
LEADS = 12
"""Number of drawn cars; those with such a height are put ahead in turn. Ours."""


@dataclass(frozen=True)
class FarDrive:
    """One drive to record; it is passed to another process."""

    folder: Path
    town: str
    maps: str | None
    seed: int
    scenes: int
    queued: bool = False
    """True if a low car is stopped close ahead in each scene."""


def record(drive: FarDrive) -> int:
    """Record one drive and return the number of images.

    Raises:
        ServerError: The server fails.
        SensorError: A sensor fails.
    """
    random = np.random.default_rng(drive.seed)
    with carlette_server(drive.town, drive.maps, drive.seed, scenery=True) as server:
        client = connect(server, CLIENT_LIMIT_S)
        world = client.get_world()
        set_synchronous(world, STEP_S)
        sort, weather = drawn_weather(random)
        world.set_weather(weather)
        stage = _FarSceneActors(client, world, random, dark="night" in sort, queued=drive.queued)
        about = {"town": drive.town, "weather": sort, "seed": drive.seed, "scenario": "far_scenes"}
        writer = RecordingWriter(drive.folder, stage.rig, about, ticks_in_file=40)
        for scene in range(drive.scenes):
            for look, tick in enumerate(stage.looks()):
                writer.add(tick(scene * SCENE_S + look * LOOK_S))
        writer.close()
        stage.close()
    return 2 * drive.scenes


def strip_rig(rig: Rig) -> Rig:
    """Return the rig with a camera of only the rows around the horizon, `STRIP_ROWS` and a margin.

    The horizon keeps its position relative to the center of the image, so that the lens is the same.
    """
    off = abs(horizon_row(rig.camera) - rig.camera.height_px / 2.0)
    rows = STRIP_ROWS + 2 * MARGIN_ROWS + 2 * round(off)
    return rig.model_copy(update={"camera": rig.camera.model_copy(update={"height_px": rows})})


class _FarSceneActors:
    """The actors of a drive, which are placed anew for each scene."""

    def __init__(self, client: Any, world: Any, random: np.random.Generator, *, dark: bool, queued: bool) -> None:
        self.rig = strip_rig(load_rig())
        self._client, self._world, self._random, self._dark = client, world, random, dark
        self._places = Places(world.get_map(), random)
        library = world.get_blueprint_library()
        self._ego = spawn_away(world, library.find("vehicle.lincoln.mkz_2020"), 0)
        cars = [item for item in library.filter("vehicle.*") if item.get_attribute("number_of_wheels").as_int() > 2]
        bikes = [item for item in library.filter("vehicle.*") if item.get_attribute("number_of_wheels").as_int() == 2]
        people = list(library.filter("walker.pedestrian.*"))
        wanted = [*[cars] * VEHICLES, *[bikes] * TWO_WHEELERS, *[people] * WALKERS]
        self._actors = [spawn_away(world, draw_blueprint(random, sort), k + 1) for k, sort in enumerate(wanted)]
        first = len(wanted) + 1
        leads = [spawn_away(world, draw_blueprint(random, cars), first + k) for k in range(LEADS if queued else 0)]
        world.tick()
        self._leads = [lead for lead in leads if LEAD_HEIGHT_M[0] < 2.0 * lead.bounding_box.extent.z < LEAD_HEIGHT_M[1]]
        for lead in leads:
            if lead not in self._leads:
                lead.destroy()
        self._lead: tuple[Any, ActorPose] | None = None
        self._truth = TruthReader(world, self._ego.id)
        self._camera = MountedSensor(self._ego, camera_setup(self.rig.camera, EVERY_TICK))
        self._masks = MountedSensor(self._ego, camera_setup(self.rig.camera, EVERY_TICK, INSTANCE_CAMERA))

    def looks(self) -> Iterator[Any]:
        """Yield the two images of a new scene, as functions from the time stamp (s) to the recorded data."""
        ego, others = self._new_scene()
        for _ in range(2):
            moves = [carla.command.ApplyTransform(self._ego, ego.transform())]
            moves += [carla.command.ApplyTransform(a, p.transform()) for a, p in zip(self._actors, others, strict=True)]
            if self._lead is not None:
                moves.append(carla.command.ApplyTransform(self._lead[0], self._lead[1].transform()))
            self._client.apply_batch_sync(moves, False)
            self._world.tick()
            yield self._recorded
            ego = ego.moved(LOOK_S)
            others = [other.moved(LOOK_S) for other in others]

    def close(self) -> None:
        """Destroy the cameras."""
        self._camera.close()
        self._masks.close()

    def _new_scene(self) -> tuple[ActorPose, list[ActorPose]]:
        random = self._random
        ego = self._places.ego()
        most = 0 if random.random() < EMPTY_SHARE else int(random.choice(CROWDS))
        placed = [*self._places.vehicles(ego, VEHICLES, most), *self._places.vehicles(ego, TWO_WHEELERS, most and 2)]
        placed += self._places.walkers(ego, WALKERS, most and 3)
        self._queue(ego)
        for actor in (*self._actors, *self._leads):
            if actor.type_id.startswith("vehicle."):
                actor.set_light_state(LIGHTS(_lamps(random, dark=self._dark)))
        return ego, placed

    def _queue(self, ego: ActorPose) -> None:
        """Choose the car ahead of this scene, and move the one of the last scene away."""
        if not self._leads:
            return
        if self._lead is not None:
            number = self._leads.index(self._lead[0])
            away = ActorPose(AWAY_M + 20.0 * number, -AWAY_M - 40.0, 0.0, 0.0, 0.0, 0.0)
            self._client.apply_batch_sync([carla.command.ApplyTransform(self._lead[0], away.transform())], False)
        lead = self._leads[int(self._random.integers(len(self._leads)))]
        gap_m = self._random.uniform(*QUEUED_M)
        reach_m = self._ego.bounding_box.extent.x + lead.bounding_box.extent.x
        self._lead = lead, self._places.ahead_of(ego, reach_m + gap_m)

    def _recorded(self, time_s: float) -> Recorded:
        snapshot = self._world.get_snapshot()
        frame = int(snapshot.frame)
        return Recorded(
            time_s=time_s,
            pose=ego_pose(snapshot.find(self._ego.id)),
            sweep=LidarSweep(time_s, np.zeros((0, 4), np.float32)),
            imu=np.zeros(7),
            gnss=np.zeros(3),
            wheel_mps=0.0,
            truth=self._truth.read(snapshot),
            lights=None,
            jpeg=encoded(self._camera.measurement(frame), JPEG_QUALITY),
            instances=instance_ids(self._masks.measurement(frame)),
        )


def _lamps(random: np.random.Generator, *, dark: bool) -> int:
    """Draw a vehicle's light state: most have their lamps on at night, many by day; some brake or blink."""
    state = LIT if random.random() < (0.85 if dark else 0.35) else 0
    if random.random() < 0.15:
        state |= int(LIGHTS.Brake)
    if random.random() < 0.08:
        state |= int(LIGHTS.LeftBlinker | LIGHTS.RightBlinker)
    if random.random() < 0.05:
        state |= int(LIGHTS.HighBeam)
    return state


def main(arguments: Sequence[str] | None = None) -> int:
    """Record drives in parallel; return 1 if any failed. A failed drive is reported, and the others continue."""
    scenes = "scenes in each drive, with two images each"
    parser = options(
        "Records scenes for the detector of far vehicles.", TOWNS, drives=24, scenes=50, scenes_help=scenes
    )
    parser.add_argument("--queued", action="store_true", help="a low car stands close ahead of the ego in each scene")
    args = parser.parse_args(arguments)
    towns = args.towns.split(",")
    drives = [
        FarDrive(
            args.out / f"far-{args.seed}-{k:04d}",
            towns[k % len(towns)],
            args.maps,
            args.seed * 10007 + k,
            args.scenes,
            args.queued,
        )
        for k in range(args.drives)
    ]
    return record_all(record, drives, args.jobs)


if __name__ == "__main__":
    sys.exit(main())
