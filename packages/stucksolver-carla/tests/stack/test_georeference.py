"""A fix comes back to the place on the map that the simulator's receiver made it of."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from carlette.geometry import Vector
from carlette.sensors.gnss import geo_point, map_reference
from stucksolver_perception.carla.georeference import EARTH_RADIUS_M, GeoReference


def opendrive(latitude_deg, longitude_deg):
    reference = f"+proj=tmerc +lat_0={latitude_deg!r} +lon_0={longitude_deg!r} +k=1"
    return f"<OpenDRIVE><header><geoReference><![CDATA[{reference}]]></geoReference></header></OpenDRIVE>"


@given(
    origin=st.tuples(st.floats(-70.0, 70.0), st.floats(-179.0, 179.0)),
    place=st.tuples(st.floats(-3000.0, 3000.0), st.floats(-3000.0, 3000.0)),
)
def test_local_of_receiver_fix_is_original_place(origin, place):
    """The fix that the receiver computes for a place gives that place again."""
    text, (x, y) = opendrive(*origin), place
    point = geo_point(map_reference(text), Vector(x, -y, 0.0))
    assert GeoReference(text).local(point.latitude, point.longitude) == pytest.approx((x, y), abs=1e-4)


def test_local_degree_north_is_degree_of_great_circle():
    """A degree north of the equator is a degree of the earth's circle."""
    x, y = GeoReference("<OpenDRIVE/>").local(0.001, 0.002)
    degree_m = math.radians(1.0) * EARTH_RADIUS_M
    assert (x, y) == (pytest.approx(0.002 * degree_m), pytest.approx(0.001 * degree_m, rel=1e-6))


def test_the_maps_own_origin_is_the_local_origin():
    geo = GeoReference(opendrive(49.0, 8.4))
    assert geo.local(49.0, 8.4) == (0.0, 0.0)
    x, _ = geo.local(49.0, 8.401)
    assert x == pytest.approx(math.radians(0.001) * math.cos(math.radians(49.0)) * EARTH_RADIUS_M)
