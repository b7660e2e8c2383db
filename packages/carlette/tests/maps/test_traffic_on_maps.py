"""The client's traffic manager drives on every map that ships without losing its lanes or its way."""

from __future__ import annotations

import pytest

pytest.importorskip("carla")

from test_traffic import serve, traffic

pytestmark = pytest.mark.integration

CARS, TICKS = 25, 800


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["interurban", *(pytest.param(item, marks=pytest.mark.release) for item in ("grid_town", "motorway"))]
)
def test_cars_drive_forty_seconds_in_their_lanes(name):
    with serve(name) as port:
        result = traffic(port, CARS, TICKS)
    assert result["cars"] == CARS
    assert result["moved"] == CARS
    assert result["median_m"] < 0.1
    assert result["p95_m"] < 0.6
