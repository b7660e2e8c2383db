"""The context of a handler."""

from __future__ import annotations

from typing import Any

from carlette.errors import RequestError
from carlette.rpc.connection import RpcConnection
from carlette.simulator import Simulator
from carlette.world.actor import Actor, ActorKind
from carlette.world.world import World


class ClientSession:
    """One client's view of the simulator."""

    def __init__(self, simulator: Simulator, connection: RpcConnection) -> None:
        self.simulator = simulator
        self.connection = connection

    @property
    def world(self) -> World:
        """World of the current episode."""
        return self.simulator.world

    def actor(self, actor_id: int, method: str) -> Actor:
        """Return an actor by id; raise `UnknownActorError` if it does not exist."""
        return self.world.actor(actor_id, method)

    def vehicle(self, actor_id: int, method: str) -> Actor:
        """Return a vehicle by id; raise `RequestError` for anything else."""
        return self._of_kind(actor_id, ActorKind.VEHICLE, method)

    def walker(self, actor_id: int, method: str) -> Actor:
        """Return a walker by id; raise `RequestError` for anything else."""
        return self._of_kind(actor_id, ActorKind.WALKER, method)

    def light(self, actor_id: int, method: str) -> Actor:
        """Return a traffic light by id; raise `RequestError` for anything else."""
        return self._of_kind(actor_id, ActorKind.LIGHT, method)

    def wire(self, actor: Actor) -> Any:
        """Return an actor in the client's form."""
        return self.simulator.actor_wire(actor)

    def _of_kind(self, actor_id: int, kind: ActorKind, method: str) -> Actor:
        actor = self.world.actor(actor_id, method)
        if actor.kind is not kind:
            raise RequestError(f"{method}: actor {actor_id} is a {actor.type_id}, not a {kind.name.lower()}")
        return actor
