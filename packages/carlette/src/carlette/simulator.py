"""The simulator: the current episode's world, the map it runs on, and what goes on the streams."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from carlette.blueprints import load_catalogue
from carlette.errors import RequestError
from carlette.memory import hand_back
from carlette.opendrive.bounds import check_bounds
from carlette.opendrive.document import MapFile, available_towns, check_opendrive, find_town
from carlette.opendrive.roads import RoadNetwork
from carlette.recorder import Recorder, Replay, ReplayOptions, default_folder
from carlette.sensors.suite import Suite
from carlette.sensors.workers import build_faces, build_static_scene
from carlette.stream.hub import Hub
from carlette.versions import ClientVersion
from carlette.wire import encode
from carlette.wire.snapshot import MAP_CHANGE, sensor_header, world_header
from carlette.wire.token import WORLD_STREAM, stream_token
from carlette.world.actor import Actor
from carlette.world.settings import EpisodeSettings
from carlette.world.trial import try_out
from carlette.world.world import World

MAP_PREFIX = "Carla/Maps/"
SENT_MAP = "OpenDriveMap"
"""What a map is called that a client sent as text."""
STREAMS_OF_AN_EPISODE = 1 << 20
EPISODES_BEFORE_STREAMS_REPEAT = 1 << 11

log = logging.getLogger(__name__)


class Simulator:
    """Everything behind the two ports, without the sockets."""

    def __init__(
        self,
        roads: RoadNetwork,
        version: ClientVersion,
        folders: Sequence[Path],
        seed: int,
        recordings: Path | None = None,
    ) -> None:
        self.version = version
        self.folders = folders
        self.seed = seed
        self.hub = Hub()
        self.stream_port = 0
        self.episode_id = 0
        self.uids = {type_id: uid for uid, type_id in enumerate(load_catalogue().definitions, 1)}
        self.traffic_managers: dict[int, str] = {}
        """Port to address, as registered by clients."""
        self.sensors = Suite(self.hub, self.stream_of, self.actor_wire)
        self.sceneries: list[Future[None]] = []
        """What the sensors that were just spawned need of the map; until it is built, the spawn may go unanswered."""
        self.parting: Future[None] | None = None
        """Until those who listened to the sensor that was just destroyed have left, that may go unanswered."""
        self.recordings = recordings or default_folder()
        """The folder out of which no recording leads."""
        self.recorder: Recorder | None = None
        self.replay: Replay | None = None
        self.replay_options = ReplayOptions()
        self.ticks_wanted = 0
        """Ticks asked for by a batch."""
        self.world = World(roads, seed)
        self._flags = 0
        self._sent: MapFile | None = None
        self.start_episode(roads)

    def build_scenery(self) -> None:
        """Builds what cameras and rays need of the present map, and compiles their loops; seconds, if at all."""
        for scenery in (build_static_scene(self.world.roads), build_faces(self.world.roads)):
            scenery.result()

    def start_episode(self, roads: RoadNetwork, settings: EpisodeSettings | None = None) -> None:
        """Replaces the world by a fresh one under a new episode id; frame numbers go on."""
        frame = self.world.frame
        self.replay = None
        if self.recorder is not None:
            self.recorder.stop()
            self.recorder = None
        if self.episode_id:
            # A client keeps what it knows of an actor under its id through all episodes, so no id may come back.
            self.world = World(roads, self.seed, self.world.next_id)
            self.sensors.close()
            self.hub.forget_late()
            hand_back()
        self.world.frame = frame
        self.world.settings = settings or EpisodeSettings()
        self.episode_id += 1
        self._flags = MAP_CHANGE

    def load_map(self, name: str, reset_settings: bool) -> None:
        """Starts an episode on a town (empty name = the current one); raises `MapError`."""
        roads = self.world.roads
        if name and name.rsplit("/", 1)[-1] != roads.file.name:
            is_sent = name.rsplit("/", 1)[-1] == SENT_MAP and self._sent is not None
            roads = RoadNetwork(self._sent if is_sent and self._sent else find_town(name, self.folders))
        self.start_episode(roads, None if reset_settings else self.world.settings)

    def load_text(self, text: str) -> None:
        """Starts an episode on an OpenDRIVE text that a client sent; raises `MapError`."""
        check_bounds(check_opendrive(text, SENT_MAP), SENT_MAP)
        try_out(text)
        sent = MapFile(SENT_MAP, text)
        self.start_episode(RoadNetwork(sent), self.world.settings)
        self._sent = sent

    @property
    def map_names(self) -> list[str]:
        """All maps that can be loaded, as clients name them."""
        return [f"/Game/{MAP_PREFIX}{name}" for name in available_towns(self.folders)]

    def token(self, stream_id: int) -> bytes:
        """The token of a stream."""
        return stream_token(stream_id, self.stream_port)

    def stream_of(self, actor: Actor) -> int:
        """The number of a sensor's stream: new in each episode.

        A client that still listens to a sensor of the last episode would take the data of another for its own.
        """
        episode = self.episode_id % EPISODES_BEFORE_STREAMS_REPEAT
        return episode * STREAMS_OF_AN_EPISODE + actor.stream_id

    def actor_wire(self, actor: Actor) -> Any:
        """An `Actor` as the client reads it."""
        attributes = [(name, int(kind), text) for name, (kind, text) in actor.attributes.items()]
        described = encode.description(self.uids.get(actor.type_id, 0), actor.type_id, attributes, self.version)
        token = self.token(self.stream_of(actor)) if actor.stream_id else b""
        return [actor.id, actor.parent_id, described, encode.box(actor.box), actor.tags, token]

    def tick(self) -> int:
        """Moves the world on, lets the sensors measure and returns the new frame number."""
        frame = self.world.tick()
        if self.replay is not None:
            self._play(self.replay)
        if self.recorder is not None:
            self.recorder.note(self.world)
        self.sensors.measure(self.world)
        return frame

    def _play(self, replay: Replay) -> None:
        try:
            replay.step(self.world)
        except (RequestError, ValueError) as error:
            # An actor of a log may find no room in this world. The tick goes on without it.
            log.error("the replay ends here: %s", error)
            self.end_replay(keep_actors=False)
        else:
            if replay.is_over:
                self.end_replay(keep_actors=True)

    def end_replay(self, keep_actors: bool) -> None:
        """Lets go of a replay's actors, if one is playing."""
        if self.replay is not None:
            self.replay.stop(self.world, keep_actors)
            self.replay = None

    def publish(self) -> None:
        """Sends the snapshot of the last tick, then what the sensors saw in it."""
        world = self.world
        header = sensor_header(self.version.snapshot_sensor_type, world.frame, world.elapsed_s)
        episode = world_header(self.episode_id, world.step_s, self._flags)
        self.hub.publish(WORLD_STREAM, header, episode, world.bodies.record.tobytes())
        self._flags = 0
        self.hub.waits_for_readers = world.settings.synchronous
        self.sensors.publish()
