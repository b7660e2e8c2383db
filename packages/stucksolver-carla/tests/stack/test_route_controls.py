"""The lights on the route: told with their state and the way to their stop line, and no others."""

from __future__ import annotations

import pytest

carla = pytest.importorskip("carla")

from towns import demo_road  # noqa: E402

from stucksolver.scene import ControlKind, LightState  # noqa: E402
from stucksolver_carla.stack.traffic_controls import RouteTrafficControls  # noqa: E402

TO_JUNCTION = ((11, 1, 100.0), (21, -1, 60.0))
INTO_JUNCTION_200 = ((13, -1, 100.0), (25, 1, 60.0))


def controls(stage, ends) -> RouteTrafficControls:
    return RouteTrafficControls(list(stage.world.get_actors().filter("*traffic_light*")), demo_road(*ends))


@pytest.mark.parametrize("ends", [TO_JUNCTION, INTO_JUNCTION_200])
def test_red_light_ahead_is_reported_with_stop_line_distance(stage, ends):
    road, light = demo_road(*ends), stage.light(ends[0][0])
    light.set_state(carla.TrafficLightState.Red)
    light.freeze(True)
    stage.ticks(1)
    (line,) = light.get_stop_waypoints()
    arc = road.crossing(line.transform)
    front = road.start_arc + 30.0
    (control,) = controls(stage, ends).ahead(front)
    assert (control.kind, control.state, control.applies) == (ControlKind.TRAFFIC_LIGHT, LightState.RED, True)
    assert control.distance_m == pytest.approx(arc - front, abs=0.01)
    start = stage.map.get_waypoint_xodr(*ends[0]).transform.location
    straight_m = start.distance(line.transform.location)
    assert control.distance_m + 30.0 == pytest.approx(straight_m, abs=1.0)


@pytest.mark.parametrize(
    ("name", "state"),
    [("Red", "red"), ("Yellow", "yellow"), ("Green", "green"), ("Off", "off"), ("Unknown", "unknown")],
)
def test_every_state_has_its_word(stage, name, state):
    light = stage.light(11)
    light.set_state(getattr(carla.TrafficLightState, name))
    light.freeze(True)
    stage.ticks(1)
    (control,) = controls(stage, TO_JUNCTION).ahead(demo_road(*TO_JUNCTION).start_arc)
    assert control.state.value == state


def test_light_counts_near_its_line(stage):
    """A light counts from 120 m before its line to 3 m past it."""
    road = demo_road(*TO_JUNCTION)
    lights = controls(stage, TO_JUNCTION)
    arc = lights.ahead(road.start_arc)[0].distance_m + road.start_arc
    assert [len(lights.ahead(arc - m)) for m in (121.0, 119.0, 1.0, -2.9, -3.1)] == [0, 1, 1, 1, 0]
    assert lights.ahead(arc + 2.0)[0].distance_m == pytest.approx(-2.0, abs=0.01)


def test_where_no_light_stands_none_is_told(stage):
    assert controls(stage, ((3, -1, 20.0), (3, -1, 400.0))).ahead(100.0) == ()
