"""All methods; a new topic is a new file and a line here."""

from carlette.rpc.handlers import (
    actors,
    batch,
    episode,
    lights,
    maps,
    motion,
    recording,
    refusals,
    scenery,
    traffic_manager,
    vehicles,
    walkers,
)
from carlette.rpc.registry import Methods

ALL = Methods().include(
    one.methods
    for one in (
        actors,
        batch,
        episode,
        lights,
        maps,
        motion,
        recording,
        refusals,
        scenery,
        traffic_manager,
        vehicles,
        walkers,
    )
)
