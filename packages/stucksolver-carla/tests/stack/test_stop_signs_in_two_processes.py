"""What stands on the route is told through the bridge as it is told in one process: stop signs, too."""

from __future__ import annotations

import json

import pytest

carla = pytest.importorskip("carla")

from townstage import CAR, Stage  # noqa: E402

from stucksolver.scene import ControlKind  # noqa: E402
from stucksolver_bridge.world_data import WorldData  # noqa: E402
from stucksolver_carla.drivers.behavior import BehaviorDriver  # noqa: E402
from stucksolver_carla.sidecar.session import _MirroredStack  # noqa: E402
from stucksolver_carla.stack import CarlaStack  # noqa: E402
from stucksolver_eval.simulator_server import carlette_server  # noqa: E402

pytestmark = pytest.mark.integration


@pytest.fixture(scope="module")
def signed():
    """A town with stop signs."""
    with carlette_server("grid_town") as server:
        yield Stage(server.host, server.port)


def over_the_wire(message):
    return json.loads(json.dumps(message, allow_nan=False))


def before(stage, sign, meters=30.0):
    """The lane some meters before a sign's box and some beyond it."""
    box = sign.trigger_volume
    lane = stage.map.get_waypoint(sign.get_transform().transform(box.location))
    return lane.previous(meters)[0], lane.next(meters)[0]


@pytest.mark.release
def test_every_stop_sign_reaches_the_solver_where_it_stands(signed):
    signs = list(signed.world.get_actors().filter("*traffic.stop*"))
    assert len(signs) > 3
    told = 0
    for sign in signs:
        start, end = before(signed, sign)
        transform = start.transform
        transform.location.z += 0.2
        car = signed.world.spawn_actor(signed.world.get_blueprint_library().find(CAR), transform)
        signed.actors.append(car)
        signed.ticks(2)
        driver = BehaviorDriver(car, carla_map=signed.map)
        driver.set_destination(end.transform.location)
        here = CarlaStack(car, driver, signed.map)
        facts = WorldData(car, signed.map)
        there = _MirroredStack(
            over_the_wire(facts.opening(driver.route, 3.0)), lambda what, f=facts: over_the_wire(f.give(what))
        )
        ours, theirs = here.surroundings().controls, there.surroundings().controls
        assert theirs == ours
        told += sum(control.kind is ControlKind.STOP_SIGN for control in theirs)
        signed.clear()
    assert told >= len(signs) / 2
