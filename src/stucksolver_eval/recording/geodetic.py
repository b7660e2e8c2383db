"""From a fix's degrees to metres of the map, as the simulator's receiver projects them.

`carla.Map.transform_to_geolocation` cannot be used: client 0.9.16 gives latitudes of the other sign than the receiver
(CARLA issue 9389). The receiver's is a spherical Mercator projection, scaled at the latitude of the map's origin.
"""

from __future__ import annotations

import math
import re

EARTH_RADIUS_M = 6378137.0
_HEADER = re.compile(r"<geoReference>(.*?)</geoReference>", re.DOTALL)
_ORIGIN = re.compile(r"\+(lat|lon)_0=([-+0-9.eE]+)")


class GeoReference:
    """Of one map, by its OpenDRIVE text; a map that names no origin has it at 0, 0, as in CARLA."""

    def __init__(self, opendrive: str) -> None:
        header = _HEADER.search(opendrive)
        origin = {name: float(value) for name, value in _ORIGIN.findall(header[1] if header else "")}
        self._latitude_deg, self._longitude_deg = origin.get("lat", 0.0), origin.get("lon", 0.0)
        self._scale_m = math.cos(math.radians(self._latitude_deg)) * EARTH_RADIUS_M

    def local(self, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
        """(x, y) in the local frame (m), whose y points north."""
        x = math.radians(longitude_deg - self._longitude_deg) * self._scale_m
        return x, self._scale_m * (_mercator(latitude_deg) - _mercator(self._latitude_deg))


def _mercator(latitude_deg: float) -> float:
    return math.asinh(math.tan(math.radians(latitude_deg)))
