"""The client's traffic manager drives on every map that ships without losing its lanes or its way."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.integration

pytest.importorskip("carla")

CARLETTE_TESTS = Path(__file__).resolve().parent.parent / "carlette"
CARS, TICKS = 25, 1200


@pytest.fixture(scope="module")
def runs(request):
    """The traffic runs of carlette's own tests."""
    sys.path.insert(0, str(CARLETTE_TESTS))
    request.addfinalizer(lambda: sys.path.remove(str(CARLETTE_TESTS)))
    spec = importlib.util.spec_from_file_location("traffic_runs", CARLETTE_TESTS / "test_traffic.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["grid_town", "interurban", "motorway"])
def test_cars_drive_a_minute_in_their_lanes(runs, name):
    with runs.serve(name) as port:
        result = runs.traffic(port, CARS, TICKS)
    assert result["cars"] == CARS
    assert result["moved"] == CARS
    assert result["median_m"] < 0.1
    assert result["p95_m"] < 0.6
