"""The colour of a vehicle for which its client chose none.

A client sends every attribute of a blueprint, those that it left alone with their defaults. CARLA paints such a vehicle
in its blueprint's first colour; its example programs draw one of the recommended colours instead. Here the actor's id
decides between those, and no random number is drawn for it, so that nothing else changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from zlib import crc32

from carlette.blueprints.definitions import AttributeType, Definition

UNPAINTED = "255,255,254"
"""The default of every `color`. It is none of those recommended, as a client that wants white must be given white."""
COLOR = "color"


def painted(
    definition: Definition, attributes: Mapping[str, tuple[AttributeType, str]], actor_id: int
) -> dict[str, tuple[AttributeType, str]]:
    """The attributes with a recommended colour in place of none; those of a blueprint without colours as they are."""
    choices = next((one.recommended for one in definition.attributes if one.id == COLOR), ())
    if not choices or attributes.get(COLOR, (AttributeType.COLOR, UNPAINTED))[1] != UNPAINTED:
        return dict(attributes)
    # Not the id alone: a car and its sensors take ids in turn, so that each car's would leave the same rest.
    chosen = choices[crc32(f"{definition.id} {actor_id}".encode()) % len(choices)]
    return {**attributes, COLOR: (AttributeType.COLOR, chosen)}
