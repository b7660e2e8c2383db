"""Route files: what is written is read again, the benchmark's own form loads as it is, and mistakes are named."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_eval.routes import (
    Position,
    Route,
    RouteFileError,
    RoutePose,
    ScenarioSpec,
    WeatherKey,
    read_routes,
    write_routes,
)
from stucksolver_eval.routes.writer import routes_text

LEADERBOARD = """<?xml version='1.0' encoding='UTF-8'?>
<routes>
  <route id="1711" town="Town12">
    <weathers>
      <weather route_percentage="100" cloudiness="80.0"/>
      <weather route_percentage="0" cloudiness="5.0"/>
    </weathers>
    <waypoints><position x="1.5" y="-2" z="0.3"/><position x="80" y="-2" z="0"/></waypoints>
    <scenarios>
      <scenario name="Accident_1" type="Accident">
        <trigger_point x="10" y="-2" z="0" yaw="90.5"/>
        <distance value="42"/>
        <frequency from="30" to="60"/>
      </scenario>
    </scenarios>
  </route>
</routes>
"""
NAMES = st.text("abcdefgh_0123", min_size=1, max_size=8).map(lambda text: f"n{text}")
NUMBERS = st.floats(-1e5, 1e5)
POSITIONS = st.builds(Position, NUMBERS, NUMBERS, NUMBERS)
SCENARIOS = st.builds(
    ScenarioSpec,
    name=NAMES,
    type=NAMES,
    trigger=st.builds(RoutePose, POSITIONS, NUMBERS),
    parameters=st.dictionaries(NAMES, st.dictionaries(NAMES, NAMES, max_size=3), max_size=3),
)
WEATHERS = st.builds(WeatherKey, st.floats(0, 100), st.dictionaries(NAMES, NUMBERS, max_size=3))
ROUTES = st.builds(
    Route,
    id=NAMES,
    town=NAMES,
    waypoints=st.lists(POSITIONS, min_size=2, max_size=4).map(tuple),
    weathers=st.lists(WEATHERS, max_size=2).map(lambda keys: tuple(sorted(keys, key=lambda k: k.route_percentage))),
    scenarios=st.lists(SCENARIOS, max_size=2).map(tuple),
)


def refused(folder: Path, text: str) -> str:
    path = folder / "bad.xml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RouteFileError) as told:
        read_routes(path)
    assert "bad.xml" in str(told.value)
    return str(told.value)


@pytest.mark.integration
@given(routes=st.lists(ROUTES, min_size=1, max_size=3, unique_by=lambda route: route.id).map(tuple))
def test_what_is_written_is_read_again(routes: tuple[Route, ...], tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("routes") / "routes.xml"
    write_routes(path, routes)
    assert read_routes(path) == routes


def test_the_leaderboards_form_loads_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "routes.xml"
    path.write_text(LEADERBOARD, encoding="utf-8")
    (route,) = read_routes(path)
    assert (route.id, route.town, route.waypoints[0]) == ("1711", "Town12", Position(1.5, -2.0, 0.3))
    assert [key.route_percentage for key in route.weathers] == [0.0, 100.0]
    (scenario,) = route.scenarios
    assert scenario.trigger == RoutePose(Position(10.0, -2.0, 0.0), 90.5)
    assert scenario.parameters == {"distance": {"value": "42"}, "frequency": {"from": "30", "to": "60"}}


def test_malformed_xml_is_named_with_its_line(tmp_path: Path) -> None:
    assert "line 3: not well-formed" in refused(tmp_path, "<routes>\n<route>\n</routes>\n")


def test_a_missing_attribute_is_named_with_its_line(tmp_path: Path) -> None:
    assert "line 3: <route> has no id" in refused(tmp_path, LEADERBOARD.replace(' id="1711"', ""))


@pytest.mark.parametrize("text", ["north", "nan", "inf"])
def test_a_coordinate_that_is_no_finite_number_is_named(tmp_path: Path, text: str) -> None:
    assert f'x="{text}" of <position>' in refused(tmp_path, LEADERBOARD.replace('x="1.5"', f'x="{text}"'))


def test_a_route_of_one_waypoint_is_refused(tmp_path: Path) -> None:
    assert "has 1 waypoints" in refused(tmp_path, LEADERBOARD.replace('<position x="80" y="-2" z="0"/>', ""))


def test_the_same_id_twice_is_refused(tmp_path: Path) -> None:
    route = LEADERBOARD[LEADERBOARD.index("  <route ") : LEADERBOARD.index("</routes>")]
    assert "1711 occurs twice" in refused(tmp_path, LEADERBOARD.replace("</routes>", route + "</routes>"))


def test_another_root_and_an_empty_file_are_refused(tmp_path: Path) -> None:
    assert "<waypoints>, not <routes>" in refused(tmp_path, "<waypoints/>")
    assert "no <route>" in refused(tmp_path, "<routes/>")


def test_entities_cannot_be_declared(tmp_path: Path) -> None:
    assert "document type" in refused(tmp_path, '<!DOCTYPE routes [<!ENTITY a "b">]>' + routes_text([]))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(RouteFileError, match=r"cannot read file: .*nowhere\.xml"):
        read_routes(tmp_path / "nowhere.xml")


FORMAT_1 = """<?xml version='1.0' encoding='UTF-8'?>
<routes>
  <route id="7" town="Town05">
    <weather id="Custom" cloudiness="20.0" sun_altitude_angle="45.0"/>
    <waypoint pitch="360.0" roll="0.0" x="193.9" y="-154.1" yaw="270.5" z="0.2"/>
    <waypoint pitch="0.0" roll="0.0" x="151.5" y="-189.0" yaw="180.0" z="0.0" connection="RoadOption.LEFT"/>
    <waypoint x="101" y="-189"/>
  </route>
</routes>
"""


def test_route_file_of_format_1_is_read_as_plain_routes(tmp_path: Path) -> None:
    """The waypoints are the route's own elements. There are no scenarios in such a file."""
    path = tmp_path / "longest.xml"
    path.write_text(FORMAT_1, "utf-8")
    (route,) = read_routes(path)
    assert (route.id, route.town, route.scenarios) == ("7", "Town05", ())
    assert route.waypoints == (Position(193.9, -154.1, 0.2), Position(151.5, -189.0, 0.0), Position(101.0, -189.0, 0.0))
    assert route.weathers == (WeatherKey(0.0, {"cloudiness": 20.0, "sun_altitude_angle": 45.0}),)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (FORMAT_1.replace('x="101" y="-189"', 'x="101"'), "line 7: <waypoint> has no y"),
        ("<routes><route id='7' town='Town05'><waypoint x='1' y='2'/></route></routes>", "<waypoint> in format 1.0"),
    ],
    ids=["incomplete", "one waypoint"],
)
def test_mistake_in_route_file_of_format_1_is_named(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "longest.xml"
    path.write_text(text, "utf-8")
    with pytest.raises(RouteFileError) as caught:
        read_routes(path)
    assert words in str(caught.value) and str(path) in str(caught.value)
