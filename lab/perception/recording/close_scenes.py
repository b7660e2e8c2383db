"""Records staged scenes for the crop network: objects 4 to 70 m ahead with any lamps, doors and gestures.

```
python -m lab.perception.recording.close_scenes --out DIR --drives 64 --seed 1 --jobs 16
```

A drive is one town in one weather. Each scene places the ego, often before a traffic light, and a selection of actors
of all kinds anew. It is recorded once unchanged, and once more for each of `PARTS` with that lamp switched, or doors
opened or closed, on all vehicles: where a vehicle's pixels change, the part is visible to the camera (`Truth.shown`).
Rain, which would change pixels too, falls only in one more image of the scene. The recordings have the usual format,
without LiDAR points. In drives, few lamps are lit, hardly any door is open, and no flagger signals; here all of this
is frequent.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import carla
import numpy as np
from numpy.typing import NDArray

from lab.perception.evaluation.scoring.samples import mask_id
from lab.perception.recording.close_scene_actors import CloseCast
from lab.perception.recording.far_scene_poses import AWAY_M, ActorPose
from lab.perception.recording.ground_truth import LightsReader, TruthReader, ego_pose
from lab.perception.recording.recording_sensors import INSTANCE_CAMERA, MountedSensor, encoded, instance_ids
from lab.perception.recording.scattered_objects import SIGNALS
from lab.perception.recording.staged_scenes import CLIENT_LIMIT_S, copied, drawn_weather, options, record_all
from stucksolver.scene.objects import VEHICLES
from stucksolver_carla.client_connection import connect
from stucksolver_eval.simulator_server import carlette_server, set_synchronous
from stucksolver_perception.camera.crops import CROP_PX, windows_of
from stucksolver_perception.carla.sensor_conversion import camera_rgb
from stucksolver_perception.carla.sensor_mounting import camera_setup
from stucksolver_perception.measurements import Floats, LidarSweep, Pixels
from stucksolver_perception.recording import PARTS, LightTruth, Recorded, RecordingWriter, Truth
from stucksolver_perception.rig import load_rig
from stucksolver_perception.vehicle_frame import boxes_in_body

TOWNS = ("Town01", "Town04", "interurban", "motorway", "grid_town", "demo_town")
STEP_S = 5.6
"""Time between two images (s): doors open fully.

It is a whole number of the periods of blinkers and of emergency lights in carlette, so that all images of a drive have
the same phase.
"""
SHORT_STEP_S = 0.1
"""Step of the simulation between scenes (s)."""
PHASES_S = (0.2, 1.5)
"""Phases with lit blinkers (s); in the second one the other half of the emergency lights is lit."""
LAMP_CHANGE, DOOR_CHANGE = 60, 30
"""Least change of a pixel's strongest channel, of 255, for a lamp and for a door. Ours."""
LAMP_PX, DOOR_PX = 0.7, 3.0
"""Least area of the change, in pixels of the network's crop. Ours."""
LIGHTS_WITHIN_M = 110.0
"""Distance within which traffic lights are recorded (m). Ours."""


@dataclass(frozen=True)
class CloseDrive:
    """One drive to record; it is passed to another process."""

    folder: Path
    town: str
    maps: str | None
    seed: int
    scenes: int
    gestures: bool = False
    """True for one image of each scene, with many flaggers."""


@dataclass(frozen=True, eq=False)
class _SceneImage:
    """One image of a scene."""

    pose: Floats
    truth: Truth
    lights: LightTruth
    jpeg: bytes
    rgb: Pixels
    ids: NDArray[np.uint16]

    def recorded(self, time_s: float, shown: Mapping[int, int]) -> Recorded:
        """Return it with the visible parts by actor."""
        bits = np.array([shown.get(item, -1) for item in self.truth.actor_id.tolist()], np.int64)
        return Recorded(
            time_s=time_s,
            pose=self.pose,
            sweep=LidarSweep(time_s, np.zeros((0, 4), np.float32)),
            imu=np.zeros(7),
            gnss=np.zeros(3),
            wheel_mps=0.0,
            truth=replace(self.truth, shown=bits),
            lights=self.lights,
            jpeg=self.jpeg,
            instances=self.ids,
        )


def record(drive: CloseDrive) -> int:
    """Record one drive and return the number of images.

    Raises:
        ServerError: The server fails.
        SensorError: A sensor fails.
    """
    random = np.random.default_rng(drive.seed)
    with carlette_server(drive.town, drive.maps, drive.seed, scenery=True) as server:
        client = connect(server, CLIENT_LIMIT_S)
        world = client.get_world()
        # Switch off physics: nothing moves, and the client would warn of steps that are too long for it.
        settings = world.get_settings()
        settings.substepping = False
        world.apply_settings(settings)
        set_synchronous(world, STEP_S)
        sort, weather = drawn_weather(random)
        stage = _CloseSceneActors(client, world, random, weather, dark="night" in sort, gestures=drive.gestures)
        about = {"town": drive.town, "weather": sort, "seed": drive.seed, "scenario": "close_scenes"}
        writer = RecordingWriter(drive.folder, stage.rig, about, ticks_in_file=10)
        taken = 0
        for _ in range(drive.scenes):
            for item in stage.scene():
                writer.add(item)
                taken += 1
        writer.close()
        stage.close()
    return taken


class _CloseSceneActors:
    """The actors of a drive; some are placed anew for each scene."""

    def __init__(
        self,
        client: Any,
        world: Any,
        random: np.random.Generator,
        weather: carla.WeatherParameters,
        *,
        dark: bool,
        gestures: bool,
    ) -> None:
        self.rig = load_rig()
        self._weather, self._dry, self._images = weather, copied(weather), 0
        self._dry.precipitation = 0.0
        self._client, self._world, self._random = client, world, random
        self._gestures = gestures
        self._cast = CloseCast(world, random, dark=dark, gestures=gestures)
        self._lights = list(world.get_actors().filter("traffic.traffic_light*"))
        for light in self._lights:
            light.freeze(True)
        world.tick()
        _align(world, float(random.choice(PHASES_S)))
        self._cast.measure()
        others, ego = self._cast.by_id(), self._cast.ego
        self._truth = TruthReader(world, ego.id, lambda actor: others[actor].doors if actor in others else 0)
        self._light_truth = LightsReader(world)
        self._camera = MountedSensor(ego, camera_setup(self.rig.camera, 0.0))
        self._masks = MountedSensor(ego, camera_setup(self.rig.camera, 0.0, INSTANCE_CAMERA))

    def scene(self) -> list[Recorded]:
        """Stage a new scene and take its images."""
        self._world.set_weather(self._weather if self._gestures else self._dry)
        ego = self._cast.draw_ego_pose(self._lights)
        moves = [carla.command.ApplyTransform(self._cast.ego, ego.transform())]
        there = []
        for number, (extra, pose) in enumerate(self._cast.placed(ego)):
            if pose is None:
                pose = ActorPose(AWAY_M + 20.0 * number, -AWAY_M - 40.0, 0.0, 0.0, 0.0, 0.0)
            elif extra.kind in VEHICLES:
                there.append(extra)
            moves.append(carla.command.ApplyTransform(extra.actor, pose.transform()))
        self._client.apply_batch_sync(moves, False)
        for light in self._lights:
            at = light.get_location()
            if math.hypot(at.x - ego.x, at.y - ego.y) < LIGHTS_WITHIN_M:
                light.set_state(SIGNALS[int(self._random.integers(len(SIGNALS)))])
        first = self._look()
        if self._gestures:
            return [first.recorded(self._number(), {})]
        looks, shown = [first], dict.fromkeys((extra.actor.id for extra in there), 0)
        for bit, part in enumerate(PARTS):
            before = [(extra, extra.lamps, extra.doors) for extra in there]
            for extra in there:
                self._cast.switch(extra, part)
            look = self._look()
            looks.append(look)
            switched = {item.actor.id for item, lamps, doors in before if (item.lamps, item.doors) != (lamps, doors)}
            for actor in switched & self._changed(first, look, doors=part == "door_open"):
                shown[actor] |= 1 << bit
            for extra, lamps, doors in before:
                self._cast.set(extra, lamps, doors)
        if self._weather.precipitation > 0.0:
            self._world.set_weather(self._weather)
            looks.append(self._look())
        return [look.recorded(self._number(), shown) for look in looks]

    def _number(self) -> float:
        self._images += 1
        return self._images * STEP_S

    def _look(self) -> _SceneImage:
        frame = self._world.tick()
        snapshot = self._world.get_snapshot()
        pose = ego_pose(snapshot.find(self._cast.ego.id))
        image, masks = self._camera.measurement(frame), self._masks.measurement(frame)
        lights = self._light_truth.read(float(pose[0]), float(pose[1]))
        return _SceneImage(
            pose, self._truth.read(snapshot), lights, encoded(image), camera_rgb(image), instance_ids(masks)
        )

    def _changed(self, first: _SceneImage, second: _SceneImage, *, doors: bool) -> set[int]:
        """Return the ids of the objects with enough different pixels in two images of a scene."""
        boxes = boxes_in_body(first.pose, first.truth.boxes[:, [0, 1, 2, 4, 5, 6, 3]])
        windows = windows_of(self.rig.camera, boxes)
        least, area_px = (DOOR_CHANGE, DOOR_PX) if doors else (LAMP_CHANGE, LAMP_PX)
        found = set()
        for i in np.flatnonzero(windows.usable).tolist():
            column, row = windows.center[i].tolist()
            half = windows.side[i] / 2.0
            rows = slice(max(int(row - half), 0), int(row + half) + 1)
            columns = slice(max(int(column - half), 0), int(column + half) + 1)
            actor = int(first.truth.actor_id[i])
            own = (first.ids[rows, columns] == mask_id(actor)) | (second.ids[rows, columns] == mask_id(actor))
            differs = np.abs(first.rgb[rows, columns].astype(int) - second.rgb[rows, columns]).max(axis=2) >= least
            if np.count_nonzero(own & differs) * (CROP_PX / windows.side[i]) ** 2 >= area_px:
                found.add(actor)
        return found

    def close(self) -> None:
        """Destroy the cameras."""
        self._camera.close()
        self._masks.close()


def _align(world: Any, phase_s: float) -> None:
    """Tick until the simulated time is `phase_s` after a multiple of `STEP_S`; from then on, ticks have that length."""
    # A change of the tick's length makes the world tick a few times, so that only whole steps may follow.
    set_synchronous(world, SHORT_STEP_S)
    for _ in range(math.ceil(STEP_S / SHORT_STEP_S)):
        off_s = (float(world.get_snapshot().timestamp.elapsed_seconds) - phase_s) % STEP_S
        if min(off_s, STEP_S - off_s) <= 0.5 * SHORT_STEP_S:
            break
        world.tick()
    set_synchronous(world, STEP_S)


def main(arguments: Sequence[str] | None = None) -> int:
    """Record drives in parallel; return 1 if any failed. A failed drive is reported, and the others continue."""
    scenes = "scenes in each drive, with six or seven images each"
    parser = options("Records scenes for the crop network.", TOWNS, drives=32, scenes=10, scenes_help=scenes)
    parser.add_argument("--gestures", action="store_true", help="one image of each scene, with many flaggers")
    args = parser.parse_args(arguments)
    towns = args.towns.split(",")
    drives = [
        CloseDrive(
            args.out / f"close-{args.seed}-{k:04d}",
            towns[k % len(towns)],
            args.maps,
            args.seed * 10007 + k,
            args.scenes,
            args.gestures,
        )
        for k in range(args.drives)
    ]
    return record_all(record, drives, args.jobs)


if __name__ == "__main__":
    sys.exit(main())
