"""All methods. A new topic is a new file and a line here."""

from carlette.rpc.handlers import (
    actors,
    batch,
    environment,
    episode,
    maps,
    motion,
    recording,
    traffic_lights,
    traffic_manager,
    unsupported,
    vehicles,
    walkers,
)
from carlette.rpc.registry import Methods

ALL = Methods().include(
    item.methods
    for item in (
        actors,
        batch,
        episode,
        traffic_lights,
        maps,
        motion,
        recording,
        unsupported,
        environment,
        traffic_manager,
        vehicles,
        walkers,
    )
)
