"""The GNSS receiver: latitude, longitude and altitude from the map's reference point."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import NamedTuple

import msgpack
import numpy as np

from carlette.geometry import Vector
from carlette.sensors.sensor import Body, Sensor, SensorAttributes, SensorTick

EARTH_RADIUS_M = 6378137.0
"""Radius of the Earth in WGS 84 (m)."""
SMALLEST_SEED, LARGEST_SEED = -(1 << 31), (1 << 31) - 1
"""Range of `noise_seed`: 32 bits with a sign."""
_REFERENCE = re.compile(r"\+(lat|lon)_0=([-+0-9.eE]+)")
_HEADER = re.compile(r"<geoReference>(.*?)</geoReference>", re.DOTALL)
_FIELDS = ("lat", "lon", "alt")


class GeoPoint(NamedTuple):
    """Latitude and longitude (degrees), altitude (m)."""

    latitude: float
    longitude: float
    altitude_m: float


class GnssSensor(Sensor):
    """The antenna's position, with a constant bias and Gaussian noise on each number, from CARLA's attributes."""

    wire_type = 4

    def __init__(self, settings: SensorAttributes) -> None:
        super().__init__(settings)
        self._bias = np.array([settings.number(f"noise_{field}_bias") for field in _FIELDS])
        self._stddev = np.array([settings.number(f"noise_{field}_stddev", 0.0) for field in _FIELDS])
        self._random = seeded(settings)

    def measure(self, moment: SensorTick) -> Iterator[Body]:
        origin = map_reference(moment.scene.world.roads.file.text)
        truth = geo_point(origin, moment.pose.location)
        noisy = np.array(truth) + self._bias + self._random.normal(0.0, 1.0, 3) * self._stddev
        yield (msgpack.packb(noisy.tolist()),)


def seeded(settings: SensorAttributes) -> np.random.Generator:
    """Return the random generator of a sensor with the attribute `noise_seed`: the same seed gives the same noise."""
    return np.random.default_rng(settings.whole("noise_seed", SMALLEST_SEED, LARGEST_SEED) - SMALLEST_SEED)


def map_reference(opendrive: str) -> GeoPoint:
    """Return `lat_0` and `lon_0` of a map's geoReference; 0, 0 without one, as in CARLA's towns."""
    header = _HEADER.search(opendrive)
    found = dict(_REFERENCE.findall(header[1])) if header else {}
    return GeoPoint(float(found.get("lat", 0.0)), float(found.get("lon", 0.0)), 0.0)


def geo_point(origin: GeoPoint, place: Vector) -> GeoPoint:
    """Return the geographic position of a point of the map: spherical Mercator scaled at the origin's latitude.

    It equals `carla.Map.transform_to_geolocation` of 0.9.15. CARLA's y points south.
    """
    scaled_m = math.cos(math.radians(origin.latitude)) * EARTH_RADIUS_M
    north_m = scaled_m * math.log(math.tan(math.radians(90.0 + origin.latitude) / 2.0)) - place.y
    longitude = origin.longitude + math.degrees(place.x / scaled_m)
    latitude = math.degrees(2.0 * math.atan(math.exp(north_m / scaled_m))) - 90.0
    return GeoPoint(latitude, longitude, origin.altitude_m + place.z)
