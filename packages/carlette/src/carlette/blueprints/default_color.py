"""The color of a vehicle whose client did not choose one.

A client sends every attribute of a blueprint, with defaults for those that it did not set. CARLA paints such a vehicle
in its blueprint's first color; its example programs draw one of the recommended colors instead. Here the actor's id
selects one of them. No random number is drawn, so that nothing else changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from zlib import crc32

from carlette.blueprints.definitions import AttributeType, Definition

UNPAINTED = "255,255,254"
"""Default of every `color`. It is not a recommended one, so that a client that asks for white gets white."""
COLOR = "color"


def painted(
    definition: Definition, attributes: Mapping[str, tuple[AttributeType, str]], actor_id: int
) -> dict[str, tuple[AttributeType, str]]:
    """Return the attributes with a recommended color filled in; unchanged for a blueprint without colors."""
    choices = next((attribute.recommended for attribute in definition.attributes if attribute.id == COLOR), ())
    if not choices or attributes.get(COLOR, (AttributeType.COLOR, UNPAINTED))[1] != UNPAINTED:
        return dict(attributes)
    # The hash avoids a pattern: cars and their sensors take ids in turn, so every car's id could leave the
    # same remainder.
    chosen = choices[crc32(f"{definition.id} {actor_id}".encode()) % len(choices)]
    return {**attributes, COLOR: (AttributeType.COLOR, chosen)}
