"""The errors of carlette. Each states the problem, its position and the remedy."""


class CarletteError(Exception):
    """Base of all errors that carlette raises on purpose."""


class StartupError(CarletteError):
    """The command cannot start. The message is one line that names the cause and the remedy."""


class MapError(StartupError):
    """An OpenDRIVE map is missing, unreadable or has no driving lane."""


class RequestError(CarletteError):
    """A client's request cannot be executed. The client raises it as `RuntimeError`."""


class SpawnCollisionError(RequestError):
    """The spawn point is occupied. CARLA's client code matches this exact text."""

    def __init__(self) -> None:
        super().__init__("Spawn failed because of collision at spawn position")


class UnknownActorError(RequestError):
    """A request names an actor that does not exist."""

    def __init__(self, actor_id: int, method: str) -> None:
        super().__init__(f"{method}: unable to find actor {actor_id}; it was destroyed or never spawned")
