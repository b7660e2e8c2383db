"""What a handler gets to work with."""

from __future__ import annotations

from typing import Any

from carlette.errors import RequestError
from carlette.rpc.connection import RpcConnection
from carlette.simulator import Simulator
from carlette.world.actor import Actor, Kind
from carlette.world.world import World


class Session:
    """One client's view of the simulator."""

    def __init__(self, simulator: Simulator, connection: RpcConnection) -> None:
        self.simulator = simulator
        self.connection = connection

    @property
    def world(self) -> World:
        """The world of the current episode."""
        return self.simulator.world

    def actor(self, actor_id: int, method: str) -> Actor:
        """An actor by id; raises `UnknownActor`."""
        return self.world.actor(actor_id, method)

    def vehicle(self, actor_id: int, method: str) -> Actor:
        """A vehicle by id; raises `RequestError` for anything else."""
        return self._of_kind(actor_id, Kind.VEHICLE, method)

    def walker(self, actor_id: int, method: str) -> Actor:
        """A walker by id; raises `RequestError` for anything else."""
        return self._of_kind(actor_id, Kind.WALKER, method)

    def light(self, actor_id: int, method: str) -> Actor:
        """A traffic light by id; raises `RequestError` for anything else."""
        return self._of_kind(actor_id, Kind.LIGHT, method)

    def wire(self, actor: Actor) -> Any:
        """An actor as the client reads it."""
        return self.simulator.actor_wire(actor)

    def _of_kind(self, actor_id: int, kind: Kind, method: str) -> Actor:
        actor = self.world.actor(actor_id, method)
        if actor.kind is not kind:
            raise RequestError(f"{method}: actor {actor_id} is a {actor.type_id}, not a {kind.name.lower()}")
        return actor
