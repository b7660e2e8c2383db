"""What a handler gets to work with."""

from __future__ import annotations

from typing import Any

from carlette.errors import CompletionRequestError
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
        """The world of the current episode."""
        return self.simulator.world

    def actor(self, actor_id: int, method: str) -> Actor:
        """An actor by id; raises `UnknownActorError`."""
        return self.world.actor(actor_id, method)

    def vehicle(self, actor_id: int, method: str) -> Actor:
        """A vehicle by id; raises `CompletionRequestError` for anything else."""
        return self._of_kind(actor_id, ActorKind.VEHICLE, method)

    def walker(self, actor_id: int, method: str) -> Actor:
        """A walker by id; raises `CompletionRequestError` for anything else."""
        return self._of_kind(actor_id, ActorKind.WALKER, method)

    def light(self, actor_id: int, method: str) -> Actor:
        """A traffic light by id; raises `CompletionRequestError` for anything else."""
        return self._of_kind(actor_id, ActorKind.LIGHT, method)

    def wire(self, actor: Actor) -> Any:
        """An actor as the client reads it."""
        return self.simulator.actor_wire(actor)

    def _of_kind(self, actor_id: int, kind: ActorKind, method: str) -> Actor:
        actor = self.world.actor(actor_id, method)
        if actor.kind is not kind:
            raise CompletionRequestError(f"{method}: actor {actor_id} is a {actor.type_id}, not a {kind.name.lower()}")
        return actor
