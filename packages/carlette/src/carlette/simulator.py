"""The simulator: the current episode's world, its map, and the data on the streams."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from carlette.allocator import release_memory
from carlette.blueprints import load_catalog
from carlette.client_versions import ClientVersion
from carlette.errors import RequestError
from carlette.opendrive.map_file import MapFile, available_towns, check_opendrive, find_town
from carlette.opendrive.road_network import RoadNetwork
from carlette.opendrive.value_limits import check_bounds
from carlette.recorder import LogRecorder, Replay, ReplayOptions, default_folder
from carlette.sensors.sensor_manager import SensorManager
from carlette.sensors.workers import build_faces, build_static_scene
from carlette.streaming import StreamHub
from carlette.wire import encode
from carlette.wire.encode import WORLD_STREAM, stream_token
from carlette.wire.snapshot import MAP_CHANGE, sensor_header, world_header
from carlette.world.actor import Actor
from carlette.world.map_trial import open_roads
from carlette.world.settings import EpisodeSettings
from carlette.world.world import World

MAP_PREFIX = "Carla/Maps/"
SENT_MAP = "OpenDriveMap"
"""Name of a map that a client sent as text."""
STREAMS_OF_AN_EPISODE = 1 << 20
"""Number of streams of one episode in the numbering of streams. Ours."""
EPISODES_BEFORE_STREAMS_REPEAT = 1 << 11
"""Number of episodes after which the numbers of streams repeat. Ours; a number of a stream has 31 bits."""

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
        self.hub = StreamHub()
        self.stream_port = 0
        self.episode_id = 0
        self.uids = {type_id: uid for uid, type_id in enumerate(load_catalog().definitions, 1)}
        self.traffic_managers: dict[int, str] = {}
        """Addresses of traffic managers by port, as registered by clients."""
        self.sensors = SensorManager(self.hub, self.stream_of, self.actor_wire)
        self.sceneries: list[Future[None]] = []
        """Parts of the map that new sensors require. The answer to the spawn request may wait for them."""
        self.parting: Future[None] | None = None
        """Done when a destroyed sensor has no subscriber left. The answer to the request may wait for it."""
        self.recordings = recordings or default_folder()
        """Folder that recordings cannot leave."""
        self.recorder: LogRecorder | None = None
        self.replay: Replay | None = None
        self.replay_options = ReplayOptions()
        self.ticks_wanted = 0
        """Number of ticks that a batch requested."""
        self.world = World(roads, seed)
        self._flags = 0
        self._sent: MapFile | None = None
        self.start_episode(roads)

    def build_scenery(self) -> None:
        """Build the parts of the present map for cameras and LiDARs, and compile their loops.

        It takes seconds unless they are built or cached.
        """
        for scenery in (build_static_scene(self.world.roads), build_faces(self.world.roads)):
            scenery.result()

    def start_episode(self, roads: RoadNetwork, settings: EpisodeSettings | None = None) -> None:
        """Replace the world with a new one with a new episode id; frame numbers continue."""
        frame = self.world.frame
        self.replay = None
        if self.recorder is not None:
            self.recorder.stop()
            self.recorder = None
        if self.episode_id:
            # Do not reuse ids: a client stores an actor's data under its id across episodes.
            self.world = World(roads, self.seed, self.world.next_id)
            self.sensors.close()
            self.hub.forget_late()
            release_memory()
        self.world.frame = frame
        self.world.settings = settings or EpisodeSettings()
        self.episode_id += 1
        self._flags = MAP_CHANGE

    def load_map(self, name: str, reset_settings: bool) -> None:
        """Start an episode on a town (empty name: the current one).

        Raises:
            MapError: The town does not exist or cannot be used.
        """
        roads = self.world.roads
        if name and name.rsplit("/", 1)[-1] != roads.file.name:
            is_sent = name.rsplit("/", 1)[-1] == SENT_MAP and self._sent is not None
            roads = open_roads(self._sent if is_sent and self._sent else find_town(name, self.folders))
        self.start_episode(roads, None if reset_settings else self.world.settings)

    def load_text(self, text: str) -> None:
        """Start an episode on an OpenDRIVE text from a client.

        Raises:
            MapError: The text cannot be used.
        """
        check_bounds(check_opendrive(text, SENT_MAP), SENT_MAP)
        sent = MapFile(SENT_MAP, text)
        self.start_episode(open_roads(sent), self.world.settings)
        self._sent = sent

    @property
    def map_names(self) -> list[str]:
        """All maps that can be loaded, by the clients' names."""
        return [f"/Game/{MAP_PREFIX}{name}" for name in available_towns(self.folders)]

    def token(self, stream_id: int) -> bytes:
        """Return the token of a stream."""
        return stream_token(stream_id, self.stream_port)

    def stream_of(self, actor: Actor) -> int:
        """Return the number of a sensor's stream: new in each episode.

        Otherwise a client that is still subscribed to a sensor of the last episode would receive another sensor's data.
        """
        episode = self.episode_id % EPISODES_BEFORE_STREAMS_REPEAT
        return episode * STREAMS_OF_AN_EPISODE + actor.stream_id

    def actor_wire(self, actor: Actor) -> Any:
        """Return an actor in the client's form."""
        attributes = [(name, int(kind), text) for name, (kind, text) in actor.attributes.items()]
        described = encode.description(self.uids.get(actor.type_id, 0), actor.type_id, attributes, self.version)
        token = self.token(self.stream_of(actor)) if actor.stream_id else b""
        return [actor.id, actor.parent_id, described, encode.box(actor.box), actor.tags, token]

    def tick(self) -> int:
        """Advance the world by one step, let the sensors measure, and return the new frame number."""
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
            # This world may have no space for an actor of the log. The tick continues without it.
            log.error("the replay ends here: %s", error)
            self.end_replay(keep_actors=False)
        else:
            if replay.is_over:
                self.end_replay(keep_actors=True)

    def end_replay(self, keep_actors: bool) -> None:
        """Release the actors of a running replay."""
        if self.replay is not None:
            self.replay.stop(self.world, keep_actors)
            self.replay = None

    def publish(self) -> None:
        """Send the snapshot of the last tick, then the sensors' data of it."""
        world = self.world
        header = sensor_header(self.version.snapshot_sensor_type, world.frame, world.elapsed_s)
        episode = world_header(self.episode_id, world.step_s, self._flags)
        self.hub.publish(WORLD_STREAM, header, episode, world.bodies.record.tobytes())
        self._flags = 0
        self.hub.waits_for_readers = world.settings.synchronous
        self.sensors.publish()
