"""The actors of staged scenes for the crop network: their selection, poses, lamps and doors.

The numbers are ours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import carla
import numpy as np

from lab.perception.recording.far_scene_poses import ActorPose, lane_places
from lab.perception.recording.scattered_kinds import blueprints_by_kind
from lab.perception.recording.staged_scenes import draw_blueprint, spawn_away
from stucksolver.scene import ObjectKind
from stucksolver.scene.objects import VEHICLES, Gesture
from stucksolver_perception.visible_parts import BRAKE, LEFT, RIGHT, SPECIAL_KINDS

NEAREST_M, FARTHEST_M = 4.0, 70.0
"""Range of the objects' distances from the ego (m)."""
CONE_RAD = math.radians(34.0)
"""Half the angle ahead of the ego within which objects are placed (rad)."""
FROM_LANE_M = 9.0
"""Maximum distance of an object from the center of a lane (m): houses are beyond."""
AT_LIGHT_SHARE, BEFORE_LIGHT_M = 0.5, (4.0, 55.0)
"""Share of egos before a traffic light, and range of their distances from it (m)."""
ALONG_SHARE = 0.75
"""Share of vehicles along the road, in either direction; the others have any heading."""
DOOR_ODDS, SECOND_DOOR_ODDS = 0.5, 0.3
"""Probabilities of an open door, and of a second one."""
SIREN_ODDS = 0.6
"""Probability that an emergency vehicle has its lights on."""
CROWDED = (0.3, 1.0)
"""Range of the share of the objects that a scene has: crowded scenes have many occlusions, others are clear."""
SIREN = int(carla.VehicleLightState.Special1)
_TRIES = 8
"""Number of tries to place an object."""
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
"""Numbers of objects by kind: those of a drive, and those of each scene."""
_FLAGGERS = 2
"""Flaggers of each gesture in a drive; one in each scene has a random gesture."""
_SIGNALLING, _MOST_SIGNALLING = 4, 14
"""Flaggers of each gesture in a drive that is staged for gestures, and their maximum in a scene."""
_BITS = {"brake_lights": BRAKE, "left_blinker": LEFT, "right_blinker": RIGHT, "emergency_lights": SIREN}
_LAMP_ODDS = (("Brake", 0.35), ("LeftBlinker", 0.22), ("RightBlinker", 0.22), ("Reverse", 0.08), ("HighBeam", 0.06))
"""Probabilities of lamps."""
_BOTH_BLINKERS_ODDS = 0.15
"""Probability that both blinkers are lit."""
_LIT_ODDS = 0.4
"""Probability that a vehicle has its lights on by day."""
_LIT_AT_NIGHT_ODDS = 0.85
"""Probability that a vehicle has its lights on at night."""
_DOORS = (carla.VehicleDoor.FL, carla.VehicleDoor.FR, carla.VehicleDoor.RL, carla.VehicleDoor.RR)


@dataclass
class Extra:
    """An actor and its last settings."""

    actor: Any
    kind: ObjectKind
    reach_m: float
    lift_m: float
    """Height of its origin above the ground (m)."""
    lamps: int = 0
    """Bits of `carla.VehicleLightState`."""
    doors: int = 0
    """See `Truth.doors`."""


class CloseCast:
    """The ego and all other actors of a drive, of which some are placed anew for each scene.

    Args:
        world: The world. It must be ticked once before `measure`.
        random: The drive's random numbers.
        dark: True at night, when most vehicles have their lights on.
        gestures: True for many flaggers.
    """

    def __init__(self, world: Any, random: np.random.Generator, *, dark: bool, gestures: bool) -> None:
        self._world, self._random, self._dark, self._gestures = world, random, dark, gestures
        self._rows = lane_places(world.get_map())
        library = world.get_blueprint_library()
        self.ego = spawn_away(world, library.find("vehicle.lincoln.mkz_2020"), 0)
        self._extras: list[Extra] = []
        by_kind = blueprints_by_kind(library)
        for kind, (count, _) in _POOL.items():
            found = [library.find(name) for name in by_kind.get(kind, ())]
            for _ in range(count if found else 0):
                self._spawn(draw_blueprint(random, found), kind)
        for name in by_kind.get(ObjectKind.FLAGGER, ()):
            for gesture in list(Gesture) * (_SIGNALLING if gestures else _FLAGGERS):
                blueprint = library.find(name)
                blueprint.set_attribute("gesture", gesture.value)
                self._spawn(blueprint, ObjectKind.FLAGGER)

    def measure(self) -> None:
        """Read the sizes of all actors."""
        for extra in self._extras:
            box = extra.actor.bounding_box
            extra.reach_m = max(0.75 * box.extent.x, box.extent.y)
            # Walkers have their origin at their center, all other actors at their foot.
            extra.lift_m = box.extent.z if extra.actor.type_id.startswith(("walker.", "animal.")) else 0.0

    def by_id(self) -> dict[int, Extra]:
        """Return all actors but the ego by id."""
        return {extra.actor.id: extra for extra in self._extras}

    def _spawn(self, blueprint: Any, kind: ObjectKind) -> None:
        actor = spawn_away(self._world, blueprint, len(self._extras) + 1)
        self._extras.append(Extra(actor, kind, 0.0, 0.0))

    def draw_ego_pose(self, lights: Sequence[Any]) -> ActorPose:
        """Draw the ego's pose: in a lane, often before one of these traffic lights."""
        random = self._random
        place = None
        if lights and random.random() < AT_LIGHT_SHARE:
            stops = lights[int(random.integers(len(lights)))].get_stop_waypoints()
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
        return ActorPose(x + right_m * math.cos(side), y + right_m * math.sin(side), z, pitch, turned, roll)

    def placed(self, ego: ActorPose) -> list[tuple[Extra, ActorPose | None]]:
        """Draw the actors of the scene and their poses, with lamps and doors; the others have no pose."""
        random = self._random
        chosen: list[Extra] = []
        share = random.uniform(*CROWDED)
        for kind in {extra.kind: None for extra in self._extras}:
            some = [extra for extra in self._extras if extra.kind is kind]
            most = _POOL[kind][1] if kind in _POOL else _MOST_SIGNALLING if self._gestures else 1
            chosen += [some[i] for i in random.permutation(len(some))[: random.binomial(most, share)]]
        taken: list[tuple[float, float, float]] = []
        poses: dict[int, ActorPose] = {}
        for extra in sorted(chosen, key=lambda item: -item.reach_m):
            pose = self._spot(ego, extra, taken)
            if pose is not None:
                poses[extra.actor.id] = pose
                taken.append((pose.x, pose.y, extra.reach_m))
                if extra.kind in VEHICLES:
                    self._draw_lamps_and_doors(extra)
        return [(extra, poses.get(extra.actor.id)) for extra in self._extras]

    def _spot(self, ego: ActorPose, extra: Extra, taken: Sequence[tuple[float, float, float]]) -> ActorPose | None:
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
            return ActorPose(x, y, self._ground(x, y, z) + extra.lift_m, pitch, turned, roll)
        return None

    def _ground(self, x: float, y: float, z: float) -> float:
        met = self._world.ground_projection(carla.Location(x, y, z + 2.0), 4.0)
        return z if met is None else float(met.location.z)

    def _draw_lamps_and_doors(self, extra: Extra) -> None:
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
        self.set(extra, lamps, self._drawn_doors() if random.random() < DOOR_ODDS else 0)

    def _drawn_doors(self) -> int:
        random = self._random
        doors = 1 << int(random.integers(len(_DOORS)))
        if random.random() < SECOND_DOOR_ODDS:
            doors |= 1 << int(random.integers(len(_DOORS)))
        return doors

    def switch(self, extra: Extra, part: str) -> None:
        """Switch one kind of lamp, or open or close doors."""
        if part == "door_open":
            self.set(extra, extra.lamps, 0 if extra.doors else self._drawn_doors())
        elif part != "emergency_lights" or extra.kind in SPECIAL_KINDS:
            self.set(extra, extra.lamps ^ _BITS[part], extra.doors)

    def set(self, extra: Extra, lamps: int, doors: int) -> None:
        """Set its lamps and doors, if it has any."""
        actor = extra.actor
        if lamps != extra.lamps and actor.attributes.get("has_lights") == "true":
            actor.set_light_state(carla.VehicleLightState(lamps))
            extra.lamps = lamps
        if doors != extra.doors and actor.attributes.get("has_dynamic_doors") == "true":
            for number, door in enumerate(_DOORS):
                if (doors ^ extra.doors) & 1 << number:
                    (actor.open_door if doors & 1 << number else actor.close_door)(door)
            extra.doors = doors
