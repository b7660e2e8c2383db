"""Converts a receiver's latitude and longitude to a position on the map.

`carla.Map.transform_to_geolocation` is not used, because client 0.9.16 gives latitudes with the opposite sign of the
server's receiver (CARLA issue 9389). This module inverts the server's own projection (`GeoReference` in CARLA 0.9.15,
MIT): spherical Mercator, scaled at the origin's latitude.
"""

from __future__ import annotations

import math
import re

EARTH_RADIUS_M = 6378137.0
"""Equatorial radius of the WGS 84 ellipsoid (m)."""
_HEADER = re.compile(r"<geoReference>(.*?)</geoReference>", re.DOTALL)
_ORIGIN = re.compile(r"\+(lat|lon)_0=([-+0-9.eE]+)")


class GeoReference:
    """The projection of one map, from its OpenDRIVE text. The default origin is 0, 0, as in CARLA."""

    def __init__(self, opendrive: str) -> None:
        header = _HEADER.search(opendrive)
        origin = dict(_ORIGIN.findall(header[1])) if header else {}
        self._longitude_deg = float(origin.get("lon", 0.0))
        latitude_deg = float(origin.get("lat", 0.0))
        self._scale_m = math.cos(math.radians(latitude_deg)) * EARTH_RADIUS_M
        self._north_m = self._mercator(latitude_deg)

    def local(self, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
        """Return (x, y) in the local frame, whose y points north (m)."""
        x = math.radians(longitude_deg - self._longitude_deg) * self._scale_m
        return x, self._mercator(latitude_deg) - self._north_m

    def _mercator(self, latitude_deg: float) -> float:
        return self._scale_m * math.log(math.tan(math.radians(90.0 + latitude_deg) / 2.0))
