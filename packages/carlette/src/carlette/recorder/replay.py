"""Replays a log: spawns its actors, or uses those that still exist, and moves them along their recorded paths."""

from __future__ import annotations

import math
from dataclasses import dataclass

from carlette.blueprints import AttributeType, load_catalog
from carlette.errors import RequestError
from carlette.geometry import Floats, Pose, Rotation, Vector
from carlette.recorder.log_file import Entry, LogFile, LogFrame
from carlette.world.actor import Actor
from carlette.world.spawn import spawn
from carlette.world.traffic_lights import Color
from carlette.world.world import SPECTATOR, World

HIGH_M = 5000.0
"""Height at which actors are spawned before they are put on their paths (m). Ours; nothing else is at that height."""


@dataclass
class ReplayOptions:
    """Options of replays. Clients may change them during a replay."""

    time_factor: float = 1.0
    """Ratio of recorded time to simulated time."""
    ignores_hero: bool = False
    ignores_spectator: bool = False


class Replay:
    """A log that is playing in a world."""

    def __init__(
        self,
        tape: LogFile,
        world: World,
        start_s: float = 0.0,
        duration_s: float = 0.0,
        follow_id: int = 0,
        options: ReplayOptions | None = None,
    ) -> None:
        """Begin `start_s` after the start of the log (before its end if negative), for `duration_s` (0: all of it).

        The spectator follows the actor with the id `follow_id` in the log, unless that is 0.

        Raises:
            RequestError: The log is empty or belongs to another map.
        """
        if tape.map_name != world.roads.file.name:
            raise RequestError(
                f"the log '{tape.path}' is of map {tape.map_name}, but {world.roads.file.name} is loaded; "
                f"call load_world('{tape.map_name}') first"
            )
        if not tape.frames:
            raise RequestError(f"the log '{tape.path}' has no frames; nothing to replay")
        if not (math.isfinite(start_s) and math.isfinite(duration_s)):
            raise RequestError(f"replay_file: start {start_s} and duration {duration_s} must be numbers of seconds")
        begin = tape.duration_s + start_s if start_s < 0.0 else start_s
        self.time_s = min(max(begin, 0.0), tape.duration_s)
        self.end_s = min(self.time_s + duration_s, tape.duration_s) if duration_s > 0.0 else tape.duration_s
        self._options = options or ReplayOptions()
        self._tape = tape
        self._follow_id = follow_id
        self._index = 0
        self._actors: dict[int, Actor] = {}
        """Actors by their ids in the log."""
        self._brought: set[int] = set()
        self._colors: dict[int, int] = {}
        self.is_over = False

    def step(self, world: World) -> None:
        """Put all actors at their positions in the log at this time, and advance the time by one tick."""
        now, after, share = self._frames()
        self._meet(world, now)
        later = dict(zip(after.ids.tolist(), after.motion, strict=True))
        for number, motion in zip(now.ids.tolist(), now.motion, strict=True):
            actor = self._actors.get(number)
            if actor is not None and not self._is_left_out(self._tape.entries[number]):
                self._lead(world, actor, motion, later.get(number, motion), share)
        self._follow(world)
        self._paint(world, now)
        world.bodies.publish()
        self.is_over = self.time_s >= self.end_s
        self.time_s = min(self.time_s + world.step_s * self._options.time_factor, self.end_s)

    def stop(self, world: World, keep_actors: bool) -> None:
        """Release the actors to the physics, or remove those that the replay spawned."""
        for number, actor in self._actors.items():
            if world.actors.get(actor.id) is not actor:
                continue
            if number in self._brought and not keep_actors:
                world.remove(actor.id)
            elif actor.touches and world.bodies.mass[actor.row] > 0.0:
                world.bodies.simulated[actor.row] = True
        self.is_over = True

    def _frames(self) -> tuple[LogFrame, LogFrame, float]:
        """Return the frames around the present time, and the share of the path from the first to the second."""
        frames = self._tape.frames
        if frames[self._index].time_s > self.time_s:
            self._index = 0
        while self._index + 1 < len(frames) and frames[self._index + 1].time_s <= self.time_s + 1e-6:
            self._index += 1
        now, after = frames[self._index], frames[min(self._index + 1, len(frames) - 1)]
        span = after.time_s - now.time_s
        return now, after, min(max((self.time_s - now.time_s) / span, 0.0), 1.0) if span > 1e-9 else 0.0

    def _meet(self, world: World, frame: LogFrame) -> None:
        """Spawn the actors that are new, and destroy those that are no longer in the log."""
        there = set(frame.ids.tolist())
        for number in [item for item in self._actors if item not in there]:
            actor = self._actors.pop(number)
            if number in self._brought and actor.id in world.actors:
                world.remove(actor.id)
        for number in frame.ids.tolist():
            known = self._actors.get(number)
            if known is None or world.actors.get(known.id) is not known:
                found = self._found(world, self._tape.entries[number])
                if found is not None:
                    self._actors[number] = found

    def _found(self, world: World, entry: Entry) -> Actor | None:
        """Return the actor of an entry: the one that still has its id and kind, or a new one."""
        same = world.actors.get(entry.id)
        if entry.type_id == SPECTATOR:
            return world.spectator
        if self._is_left_out(entry):
            return None
        if same is None or same.type_id != entry.type_id:
            if entry.type_id not in load_catalog().definitions:
                return None
            attributes = {name: (AttributeType(kind), text) for name, (kind, text) in entry.attributes.items()}
            same = spawn(world, entry.type_id, attributes, Pose(Vector(0.0, 10.0 * entry.id, HIGH_M)))
            self._brought.add(entry.id)
        world.bodies.simulated[same.row] = False
        return same

    def _is_left_out(self, entry: Entry) -> bool:
        if entry.type_id == SPECTATOR:
            return self._options.ignores_spectator or self._follow_id > 0
        return self._options.ignores_hero and entry.role == "hero"

    @staticmethod
    def _lead(world: World, actor: Actor, now: Floats, after: Floats, share: float) -> None:
        place = now[:3] + share * (after[:3] - now[:3])
        turn = now[3:6] + share * ((after[3:6] - now[3:6] + 180.0) % 360.0 - 180.0)
        world.teleport(actor, Pose(Vector(*place.tolist()), Rotation(*turn.tolist())))
        world.bodies.velocity[actor.row] = now[6:9] + share * (after[6:9] - now[6:9])

    def _follow(self, world: World) -> None:
        followed = self._actors.get(self._follow_id)
        if followed is not None and not self._options.ignores_spectator:
            pose = world.pose(followed)
            behind = Pose(pose.location, Rotation(yaw=pose.rotation.yaw)).compose(
                Pose(Vector(-8.0, 0.0, 5.0), Rotation(pitch=-20.0))
            )
            world.teleport(world.spectator, behind)

    def _paint(self, world: World, frame: LogFrame) -> None:
        for number, color in zip(frame.light_ids.tolist(), frame.light_colors.tolist(), strict=True):
            light = world.actors.get(number)
            if light is not None and self._colors.get(number) != color and light.index >= 0:
                self._colors[number] = color
                world.signals.set_color(light.index, Color(color))
        world.signals.publish(world.bodies)
