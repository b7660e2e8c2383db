"""Records staged scenes for the crop network: objects 4 to 70 m ahead with any lamps, doors and gestures.

`python -m stucksolver_eval.perception.close_scenes --out DIR --drives 64 --seed 1 --jobs 16`

A drive is one town in one weather. Each scene places the ego, often before a traffic light, and a selection of actors
of all kinds anew. It is taken once as it is, and once more for each of `PARTS` with that lamp switched, or doors opened
or closed, on all vehicles: where a vehicle's pixels change, the camera can see that part (`Truth.shown`). Rain, which
would change pixels too, falls only in one more image of the scene. The recordings have the usual format, without LiDAR
points. In drives, few lamps are lit, hardly any door is open, and no flagger signals; here all of this is frequent.
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

from stucksolver.perception.camera.crops import CROP_PX, windows_of
from stucksolver.perception.measurements import Floats, LidarSweep, Pixels
from stucksolver.perception.recording import PARTS, LightTruth, Recorded, RecordingWriter, Truth
from stucksolver.perception.rig import load_rig
from stucksolver.perception.visible_parts import BRAKE, LEFT, RIGHT, SPECIAL_KINDS
from stucksolver.scene import ObjectKind
from stucksolver.scene.objects import VEHICLES, Gesture
from stucksolver.stacks.sensed.mounting import camera_setup
from stucksolver.stacks.sensed.readings import camera_rgb
from stucksolver_eval.perception.far_places import AWAY_M, Posed, lane_places
from stucksolver_eval.perception.scoring.samples import boxes_in_body, mask_id
from stucksolver_eval.perception.staged import (
    CLIENT_LIMIT_S,
    copied,
    drawn,
    drawn_weather,
    options,
    record_all,
    spawn_away,
)
from stucksolver_eval.recording.crowd import SIGNALS, blueprints_by_kind
from stucksolver_eval.recording.mounted import INSTANCE_CAMERA, MountedSensor, encoded, instance_ids
from stucksolver_eval.recording.truth import LightsReader, TruthReader, ego_pose
from stucksolver_eval.server import carlette_server, connect, set_synchronous

TOWNS = ("Town01", "Town04", "interurban", "motorway", "grid_town", "demo_town")
STEP_S = 5.6
"""Time between two images: doors open fully. It is a whole number of the periods of blinkers and of emergency lights in
carlette, so that all images of a drive have the same phase.
"""
SHORT_STEP_S = 0.1
PHASES_S = (0.2, 1.5)
"""Phases with lit blinkers; in the second one the other half of the emergency lights is lit."""
LAMP_CHANGE, DOOR_CHANGE = 60, 30
"""Least change of a pixel's strongest channel, of 255, for a lamp and for a door."""
LAMP_PX, DOOR_PX = 0.7, 3.0
"""Least area of the change, in pixels of the crop that the network gets."""
NEAREST_M, FARTHEST_M = 4.0, 70.0
CONE_RAD = math.radians(34.0)
FROM_LANE_M = 9.0
"""Objects are at most this far from the centre of a lane, since houses are beyond."""
AT_LIGHT_SHARE, BEFORE_LIGHT_M = 0.5, (4.0, 55.0)
"""Share of egos before a traffic light, and how far before it they are (m)."""
ALONG_SHARE = 0.75
"""Share of vehicles along the road, in either direction; the others have any heading."""
DOOR_ODDS, SECOND_DOOR_ODDS = 0.5, 0.3
SIREN_ODDS = 0.6
CROWDED = (0.3, 1.0)
"""Share of the objects that a scene can have: in some everything hides everything, others are clear."""
SIREN = int(carla.VehicleLightState.Special1)
LIGHTS_WITHIN_M = 110.0
_TRIES = 8
_POOL = {
    ObjectKind.CAR: (22, 5),
    ObjectKind.EMERGENCY: (6, 2),
    ObjectKind.VAN: (6, 2),
    ObjectKind.TRUCK: (5, 1),
    ObjectKind.BUS: (4, 1),
    ObjectKind.SCHOOL_BUS: (2, 1),
    ObjectKind.MOTORCYCLE: (6, 1),
    ObjectKind.BICYCLE: (5, 1),
    ObjectKind.PEDESTRIAN: (14, 4),
    ObjectKind.ANIMAL: (6, 1),
    ObjectKind.CONE: (5, 1),
    ObjectKind.BARRIER: (5, 1),
    ObjectKind.CROSSING_GATE: (2, 1),
    ObjectKind.BAG: (4, 1),
    ObjectKind.LITTER: (4, 2),
    ObjectKind.DEBRIS: (6, 1),
    ObjectKind.PROP: (8, 1),
}
"""By kind: how many a drive has, and how many of them are in each scene."""
_FLAGGERS = 2
"""Flaggers of each gesture in a drive; one in each scene has a random gesture."""
_BITS = {"brake_lights": BRAKE, "left_blinker": LEFT, "right_blinker": RIGHT, "emergency_lights": SIREN}
_LAMP_ODDS = (("Brake", 0.35), ("LeftBlinker", 0.22), ("RightBlinker", 0.22), ("Reverse", 0.08), ("HighBeam", 0.06))
_BOTH_BLINKERS_ODDS = 0.15
_LIT_ODDS = 0.4
_LIT_AT_NIGHT_ODDS = 0.85
_DOORS = (carla.VehicleDoor.FL, carla.VehicleDoor.FR, carla.VehicleDoor.RL, carla.VehicleDoor.RR)


@dataclass(frozen=True)
class CloseDrive:
    """One drive to record; it is passed to another process."""

    folder: Path
    town: str
    maps: str | None
    seed: int
    scenes: int


@dataclass
class _Extra:
    """An actor, and what was last set on it."""

    actor: Any
    kind: ObjectKind
    reach_m: float
    lift_m: float
    """Height of its origin above the ground."""
    lamps: int = 0
    """Bits of `carla.VehicleLightState`."""
    doors: int = 0
    """See `Truth.doors`."""


@dataclass(frozen=True, eq=False)
class _Look:
    """One image of a scene."""

    pose: Floats
    truth: Truth
    lights: LightTruth
    jpeg: bytes
    rgb: Pixels
    ids: NDArray[np.uint16]

    def recorded(self, time_s: float, shown: Mapping[int, int]) -> Recorded:
        """Return it with the visible parts by actor."""
        bits = np.array([shown.get(one, -1) for one in self.truth.actor_id.tolist()], np.int64)
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
    """Record one drive and return the number of images. Raises `ServerError` and `SensorError`."""
    random = np.random.default_rng(drive.seed)
    with carlette_server(drive.town, drive.maps, drive.seed, scenery=True) as server:
        client = connect(server, CLIENT_LIMIT_S)
        world = client.get_world()
        # Nothing moves by physics; the client would warn of steps that are too long for it.
        settings = world.get_settings()
        settings.substepping = False
        world.apply_settings(settings)
        set_synchronous(world, STEP_S)
        sort, weather = drawn_weather(random)
        stage = _Stage(client, world, random, weather, dark="night" in sort)
        about = {"town": drive.town, "weather": sort, "seed": drive.seed, "scenario": "close_scenes"}
        writer = RecordingWriter(drive.folder, stage.rig, about, ticks_in_file=10)
        taken = 0
        for _ in range(drive.scenes):
            for one in stage.scene():
                writer.add(one)
                taken += 1
        writer.close()
        stage.close()
    return taken


class _Stage:
    """The actors of a drive, of which some are placed anew for each scene."""

    def __init__(
        self, client: Any, world: Any, random: np.random.Generator, weather: carla.WeatherParameters, *, dark: bool
    ) -> None:
        self.rig = load_rig()
        self._weather, self._dry, self._images = weather, copied(weather), 0
        self._dry.precipitation = 0.0
        self._client, self._world, self._random, self._dark = client, world, random, dark
        self._rows = lane_places(world.get_map())
        library = world.get_blueprint_library()
        self._ego = spawn_away(world, library.find("vehicle.lincoln.mkz_2020"), 0)
        self._extras: list[_Extra] = []
        by_kind = blueprints_by_kind(library)
        for kind, (count, _) in _POOL.items():
            found = [library.find(name) for name in by_kind.get(kind, ())]
            for _ in range(count if found else 0):
                self._spawn(drawn(random, found), kind)
        for name in by_kind.get(ObjectKind.FLAGGER, ()):
            for gesture in list(Gesture) * _FLAGGERS:
                blueprint = library.find(name)
                blueprint.set_attribute("gesture", gesture.value)
                self._spawn(blueprint, ObjectKind.FLAGGER)
        self._lights = list(world.get_actors().filter("traffic.traffic_light*"))
        for light in self._lights:
            light.freeze(True)
        world.tick()
        _align(world, float(random.choice(PHASES_S)))
        for extra in self._extras:
            box = extra.actor.bounding_box
            extra.reach_m = max(0.75 * box.extent.x, box.extent.y)
            # Walkers have their origin at their middle, everything else at its foot.
            extra.lift_m = box.extent.z if extra.actor.type_id.startswith(("walker.", "animal.")) else 0.0
        doors = {extra.actor.id: extra for extra in self._extras}
        self._truth = TruthReader(world, self._ego.id, lambda actor: doors[actor].doors if actor in doors else 0)
        self._light_truth = LightsReader(world)
        self._camera = MountedSensor(self._ego, camera_setup(self.rig.camera, 0.0))
        self._masks = MountedSensor(self._ego, camera_setup(self.rig.camera, 0.0, INSTANCE_CAMERA))

    def scene(self) -> list[Recorded]:
        """Stage a new scene and take its images."""
        self._world.set_weather(self._dry)
        ego = self._ego_pose()
        moves = [carla.command.ApplyTransform(self._ego, ego.transform())]
        there = []
        for number, (extra, pose) in enumerate(self._placed(ego)):
            if pose is None:
                pose = Posed(AWAY_M + 20.0 * number, -AWAY_M - 40.0, 0.0, 0.0, 0.0, 0.0)
            elif extra.kind in VEHICLES:
                there.append(extra)
            moves.append(carla.command.ApplyTransform(extra.actor, pose.transform()))
        self._client.apply_batch_sync(moves, False)
        for light in self._lights:
            at = light.get_location()
            if math.hypot(at.x - ego.x, at.y - ego.y) < LIGHTS_WITHIN_M:
                light.set_state(SIGNALS[int(self._random.integers(len(SIGNALS)))])
        first = self._look()
        looks, shown = [first], dict.fromkeys((extra.actor.id for extra in there), 0)
        for bit, part in enumerate(PARTS):
            before = [(extra, extra.lamps, extra.doors) for extra in there]
            for extra in there:
                self._switch(extra, part)
            look = self._look()
            looks.append(look)
            switched = {one.actor.id for one, lamps, doors in before if (one.lamps, one.doors) != (lamps, doors)}
            for actor in switched & self._changed(first, look, doors=part == "door_open"):
                shown[actor] |= 1 << bit
            for extra, lamps, doors in before:
                self._set(extra, lamps, doors)
        if self._weather.precipitation > 0.0:
            self._world.set_weather(self._weather)
            looks.append(self._look())
        return [look.recorded(self._number(), shown) for look in looks]

    def _number(self) -> float:
        self._images += 1
        return self._images * STEP_S

    def _look(self) -> _Look:
        frame = self._world.tick()
        snapshot = self._world.get_snapshot()
        pose = ego_pose(snapshot.find(self._ego.id))
        image, masks = self._camera.of(frame), self._masks.of(frame)
        lights = self._light_truth.read(float(pose[0]), float(pose[1]))
        return _Look(pose, self._truth.read(snapshot), lights, encoded(image), camera_rgb(image), instance_ids(masks))

    def _changed(self, one: _Look, other: _Look, *, doors: bool) -> set[int]:
        """Return the ids of the objects of which enough pixels differ between two images of a scene."""
        boxes = boxes_in_body(one.pose, one.truth.boxes[:, [0, 1, 2, 4, 5, 6, 3]])
        windows = windows_of(self.rig.camera, boxes)
        least, area_px = (DOOR_CHANGE, DOOR_PX) if doors else (LAMP_CHANGE, LAMP_PX)
        found = set()
        for i in np.flatnonzero(windows.usable).tolist():
            column, row = windows.center[i].tolist()
            half = windows.side[i] / 2.0
            rows = slice(max(int(row - half), 0), int(row + half) + 1)
            columns = slice(max(int(column - half), 0), int(column + half) + 1)
            actor = int(one.truth.actor_id[i])
            own = (one.ids[rows, columns] == mask_id(actor)) | (other.ids[rows, columns] == mask_id(actor))
            differs = np.abs(one.rgb[rows, columns].astype(int) - other.rgb[rows, columns]).max(axis=2) >= least
            if np.count_nonzero(own & differs) * (CROP_PX / windows.side[i]) ** 2 >= area_px:
                found.add(actor)
        return found

    def close(self) -> None:
        """Destroy the cameras."""
        self._camera.close()
        self._masks.close()

    def _spawn(self, blueprint: Any, kind: ObjectKind) -> None:
        actor = spawn_away(self._world, blueprint, len(self._extras) + 1)
        self._extras.append(_Extra(actor, kind, 0.0, 0.0))

    def _ego_pose(self) -> Posed:
        """Draw the ego's pose: in a lane, often before a traffic light."""
        random = self._random
        place = None
        if self._lights and random.random() < AT_LIGHT_SHARE:
            stops = self._lights[int(random.integers(len(self._lights)))].get_stop_waypoints()
            before_m = float(random.uniform(*BEFORE_LIGHT_M))
            back = stops[int(random.integers(len(stops)))].previous(before_m) if stops else []
            place = back[0].transform if back else None
        if place is None:
            x, y, z, pitch, yaw, roll = self._rows[int(random.integers(len(self._rows)))].tolist()
        else:
            at, turn = place.location, place.rotation
            x, y, z, pitch, yaw, roll = at.x, at.y, at.z, math.remainder(turn.pitch, 360.0), turn.yaw, turn.roll
        side, right_m = math.radians(yaw + 90.0), random.normal(0.0, 0.5)
        turned = yaw + random.normal(0.0, 3.0)
        return Posed(x + right_m * math.cos(side), y + right_m * math.sin(side), z, pitch, turned, roll)

    def _placed(self, ego: Posed) -> list[tuple[_Extra, Posed | None]]:
        """Draw who is in the scene and where, with lamps and doors; the others have no pose."""
        random = self._random
        chosen: list[_Extra] = []
        share = random.uniform(*CROWDED)
        for kind in {extra.kind: None for extra in self._extras}:
            some = [extra for extra in self._extras if extra.kind is kind]
            most = _POOL[kind][1] if kind in _POOL else 1
            chosen += [some[i] for i in random.permutation(len(some))[: random.binomial(most, share)]]
        taken: list[tuple[float, float, float]] = []
        poses: dict[int, Posed] = {}
        for extra in sorted(chosen, key=lambda one: -one.reach_m):
            pose = self._spot(ego, extra, taken)
            if pose is not None:
                poses[extra.actor.id] = pose
                taken.append((pose.x, pose.y, extra.reach_m))
                if extra.kind in VEHICLES:
                    self._draw_lamps_and_doors(extra)
        return [(extra, poses.get(extra.actor.id)) for extra in self._extras]

    def _spot(self, ego: Posed, extra: _Extra, taken: Sequence[tuple[float, float, float]]) -> Posed | None:
        random = self._random
        for _ in range(_TRIES):
            away = NEAREST_M + extra.reach_m
            away_m = math.exp(random.uniform(math.log(away), math.log(FARTHEST_M)))
            bearing = math.radians(ego.yaw_deg) + random.uniform(-CONE_RAD, CONE_RAD)
            x, y = ego.x + away_m * math.cos(bearing), ego.y + away_m * math.sin(bearing)
            offsets = self._rows[:, :2] - (x, y)
            near = int(np.argmin(np.hypot(offsets[:, 0], offsets[:, 1])))
            if math.hypot(*offsets[near].tolist()) > FROM_LANE_M:
                continue
            if any(math.hypot(x - a, y - b) < extra.reach_m + reach for a, b, reach in taken):
                continue
            z, pitch, yaw, roll = self._rows[near, 2:].tolist()
            if extra.kind in VEHICLES and random.random() < ALONG_SHARE:
                turned = yaw + random.choice((0.0, 0.0, 180.0)) + random.normal(0.0, 7.0)
            elif extra.kind is ObjectKind.FLAGGER and random.random() < ALONG_SHARE:
                turned = ego.yaw_deg + 180.0 + random.normal(0.0, 25.0)
            else:
                turned, pitch, roll = random.uniform(-180.0, 180.0), 0.0, 0.0
            return Posed(x, y, self._ground(x, y, z) + extra.lift_m, pitch, turned, roll)
        return None

    def _ground(self, x: float, y: float, z: float) -> float:
        met = self._world.ground_projection(carla.Location(x, y, z + 2.0), 4.0)
        return z if met is None else float(met.location.z)

    def _draw_lamps_and_doors(self, extra: _Extra) -> None:
        random = self._random
        names = [name for name, odds in _LAMP_ODDS if random.random() < odds]
        if random.random() < _BOTH_BLINKERS_ODDS:
            names += ["LeftBlinker", "RightBlinker"]
        if random.random() < (_LIT_AT_NIGHT_ODDS if self._dark else _LIT_ODDS):
            names += ["Position", "LowBeam"]
        if extra.kind in SPECIAL_KINDS and random.random() < SIREN_ODDS:
            names.append("Special1")
        lamps = 0
        for name in names:
            lamps |= int(getattr(carla.VehicleLightState, name))
        self._set(extra, lamps, self._drawn_doors() if random.random() < DOOR_ODDS else 0)

    def _drawn_doors(self) -> int:
        random = self._random
        doors = 1 << int(random.integers(len(_DOORS)))
        if random.random() < SECOND_DOOR_ODDS:
            doors |= 1 << int(random.integers(len(_DOORS)))
        return doors

    def _switch(self, extra: _Extra, part: str) -> None:
        """Switch one kind of lamp, or open or close doors."""
        if part == "door_open":
            self._set(extra, extra.lamps, 0 if extra.doors else self._drawn_doors())
        elif part != "emergency_lights" or extra.kind in SPECIAL_KINDS:
            self._set(extra, extra.lamps ^ _BITS[part], extra.doors)

    def _set(self, extra: _Extra, lamps: int, doors: int) -> None:
        actor = extra.actor
        if lamps != extra.lamps and actor.attributes.get("has_lights") == "true":
            actor.set_light_state(carla.VehicleLightState(lamps))
            extra.lamps = lamps
        if doors != extra.doors and actor.attributes.get("has_dynamic_doors") == "true":
            for number, door in enumerate(_DOORS):
                if (doors ^ extra.doors) & 1 << number:
                    (actor.open_door if doors & 1 << number else actor.close_door)(door)
            extra.doors = doors


def _align(world: Any, phase_s: float) -> None:
    """Tick until the simulated time is `phase_s` after a multiple of `STEP_S`; from then on, ticks are that long."""
    # Whoever sets the length of a tick lets the world tick a few times, so that only whole steps may follow.
    set_synchronous(world, SHORT_STEP_S)
    for _ in range(math.ceil(STEP_S / SHORT_STEP_S)):
        off_s = (float(world.get_snapshot().timestamp.elapsed_seconds) - phase_s) % STEP_S
        if min(off_s, STEP_S - off_s) <= 0.5 * SHORT_STEP_S:
            break
        world.tick()
    set_synchronous(world, STEP_S)


def main(arguments: Sequence[str] | None = None) -> int:
    """Record drives in parallel. A failed drive is reported, and the others continue. Returns 1 if any failed."""
    scenes = "scenes in each drive, with six or seven images each"
    parser = options("Records scenes for the crop network.", TOWNS, drives=32, scenes=10, scenes_help=scenes)
    args = parser.parse_args(arguments)
    towns = args.towns.split(",")
    drives = [
        CloseDrive(
            args.out / f"close-{args.seed}-{k:04d}",
            towns[k % len(towns)],
            args.maps,
            args.seed * 10007 + k,
            args.scenes,
        )
        for k in range(args.drives)
    ]
    return record_all(record, drives, args.jobs)


if __name__ == "__main__":
    sys.exit(main())
