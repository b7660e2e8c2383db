"""The differences between the supported client versions.

The protocol cannot query a client's version, so the server gets it at its start.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ClientVersion:
    """Numbers of the wire format that changed between client versions."""

    name: str
    snapshot_sensor_type: int
    """Sensor type index in the header of a world snapshot; a wrong one aborts the client."""
    attribute_type_offset: int
    """Added to Bool 0, Int 1, Float 2, String 3, RGBColor 4."""


VERSIONS = {
    "0.9.15": ClientVersion("0.9.15", snapshot_sensor_type=16, attribute_type_offset=0),
    "0.9.16": ClientVersion("0.9.16", snapshot_sensor_type=17, attribute_type_offset=1),
}
DEFAULT_VERSION = "0.9.16"
