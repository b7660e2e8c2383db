"""Writes one frame for each tick. A failure to write ends the recording, never the simulation."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import BinaryIO

import numpy as np

from carlette.errors import RequestError
from carlette.recorder.log_file import MAGIC, encode_entry
from carlette.world.actor import ActorKind
from carlette.world.world import World

RECORDED = (ActorKind.VEHICLE, ActorKind.WALKER, ActorKind.PROP, ActorKind.OTHER)

log = logging.getLogger(__name__)


class LogRecorder:
    """One recording."""

    def __init__(self, path: Path, world: World) -> None:
        """Begin a file; raise `RequestError` if that fails or another kind of file is there."""
        self.path = path
        self._began_s = world.elapsed_s
        self._known: set[int] = set()
        self._hits: set[tuple[int, int]] = set()
        """Pairs of actors that touched in the last frame."""
        self._file: BinaryIO | None = _begin(path)
        self._write(encode_entry("start", world.roads.file.name, time.strftime("%Y-%m-%d %H:%M:%S")))
        self.note(world)

    def note(self, world: World) -> None:
        """Record the tick that `world` has just completed."""
        if self._file is None:
            return
        actors = [actor for actor in world.actors.values() if actor.kind in RECORDED]
        parts = []
        for actor in actors:
            if actor.id not in self._known:
                attributes = {name: [int(kind), text] for name, (kind, text) in actor.attributes.items()}
                parts.append(encode_entry("spawn", actor.id, actor.type_id, attributes, actor.parent_id))
        ids = {actor.id for actor in actors}
        parts += [encode_entry("gone", item) for item in sorted(self._known - ids)]
        self._known = ids
        parts += self._collisions(world)
        rows, bodies, lights = [actor.row for actor in actors], world.bodies, world.signals.lights
        motion = np.concatenate([bodies.position[rows], bodies.rotation[rows], bodies.velocity[rows]], axis=1)
        parts.append(
            encode_entry(
                "frame",
                world.frame,
                world.elapsed_s - self._began_s,
                np.array([actor.id for actor in actors], np.uint32).tobytes(),
                motion.astype(np.float32).tobytes(),
                bodies.record["id"][lights.row].astype(np.uint32).tobytes(),
                lights.color.astype(np.uint8).tobytes(),
            )
        )
        self._write(b"".join(parts))

    def stop(self) -> None:
        """End the file."""
        if self._file is not None:
            try:
                self._file.close()
            except OSError as error:
                # A failed write ends the recording; the simulation continues.
                self._give_up(error)
            self._file = None

    def _collisions(self, world: World) -> list[bytes]:
        """Return contacts that began in this tick."""
        ids = world.bodies.record["id"]
        now, parts = set(), []
        for contact in world.contacts:
            pair = (int(ids[contact.first]), int(ids[contact.second]))
            now.add(pair)
            if pair not in self._hits:
                size = float(np.linalg.norm(contact.impulse))
                parts.append(encode_entry("hit", world.elapsed_s - self._began_s, *pair, size))
        self._hits = now
        return parts

    def _write(self, data: bytes) -> None:
        try:
            if self._file is not None:
                self._file.write(data)
                self._file.flush()
        except OSError as error:
            # A failed write ends the recording; the simulation continues.
            self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        log.error("recording to '%s' ends here: %s; the simulation goes on", self.path, error.strerror or error)
        broken, self._file = self._file, None
        if broken is not None:
            try:
                broken.close()
            except OSError:
                # Drop the file without a flush: the content of its buffer cannot be written now either.
                return


def _begin(path: Path) -> BinaryIO:
    try:
        if path.exists() and not path.is_file():
            raise RequestError(f"cannot record to '{path}': it is not a file; name a file that can be written")
        if path.exists():
            with path.open("rb") as old:
                if old.read(len(MAGIC)) != MAGIC:
                    raise RequestError(f"'{path}' exists and is not a carlette log; record to another file")
        file = path.open("wb")
        file.write(MAGIC)
        return file
    except OSError as error:
        raise RequestError(f"cannot record to '{path}': {error.strerror}; name a file that can be written") from None
