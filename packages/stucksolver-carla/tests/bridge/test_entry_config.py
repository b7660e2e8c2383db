"""The entry's configuration: what is wrong with a file is said in one sentence that names it."""

from __future__ import annotations

import json
import sys

import pytest

from stucksolver_bridge.entry_config import Config, ConfigError, read_config
from stucksolver_bridge.guidance_script import GuidancePlayer


def written(tmp_path, content):
    path = tmp_path / "config.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return path


def test_read_config_takes_file_and_last_route_name(tmp_path):
    """The evaluator passes the file and the names of all routes up to the present one."""
    path = written(tmp_path, {"recovery": "search", "python": sys.executable})
    config, name = read_config(f"{path}+RouteScenario_1_rep0_Town01+RouteScenario_2_rep0_Town02")
    assert name == "RouteScenario_2_rep0_Town02"
    assert config == Config(recovery="search", python=sys.executable)


def test_the_path_may_have_plus_signs(tmp_path):
    folder = tmp_path / "a+b" / "c+"
    folder.mkdir(parents=True)
    path = written(folder, {"obstacles": False})
    assert read_config(f"{path}+RouteScenario_1_rep0_Town01") == (
        Config(obstacles=False),
        "RouteScenario_1_rep0_Town01",
    )
    assert read_config(str(path)) == (Config(obstacles=False), "route")


@pytest.mark.parametrize(
    ("content", "named"),
    [
        ("{", "invalid JSON"),
        ("[]", "an object"),
        ({"recover": "search"}, "unknown field 'recover'"),
        ({"obstacles": "yes"}, "obstacles must be true or false"),
        ({"behavior": 3}, "behavior must be a string"),
        ({"answer_limit_s": "long"}, "answer_limit_s must be a number of seconds above 0"),
        ({"answer_limit_s": 0}, "answer_limit_s must be a number of seconds above 0"),
        ({"recovery": "search"}, "requires the field 'python'"),
        ({"recovery": "search", "python": "/no/python"}, "'/no/python' is not an executable file"),
        ({"perception": "lidar"}, "unknown perception 'lidar'; use privileged or sensors"),
        ({"perception": "sensors"}, "set 'driver' to 'planner'"),
        ({"perception": "sensors", "driver": "planner"}, "requires the field 'python'"),
        ({"perception": "sensors", "driver": "planner", "sensors": False}, "leave 'sensors' at true"),
        (
            {"perception": "sensors", "driver": "planner", "recovery": "timers"},
            "'timers' is not available with perception",
        ),
        (
            {"perception": "sensors", "driver": "planner", "python": sys.executable, "rig": "/no/rig.toml"},
            "rig file not found: '/no/rig.toml'; give the calibration",
        ),
        ({"rig": "rig.toml"}, "leave it out, or set perception"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, content, named):
    with pytest.raises(ConfigError, match=named):
        read_config(str(written(tmp_path, content)))


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r"nothing\.json"):
        read_config(str(tmp_path / "nothing.json"))


def test_guidance_player_plays_each_line_once_when_due(tmp_path):
    """The lines of a guidance script are played once, at their time."""
    lines = [
        {"when": {"stopped_s": 6}, "say": ["please overtake them", "go round"]},
        {"when": {"place_m": 50}, "say": ["slower"]},
    ]
    path = written(tmp_path, {"version": 1, "routes": {"2101": lines}})
    speaker = GuidancePlayer(str(path), "2101")
    assert speaker.due(10.0, 0.0, 5.0) == []
    assert speaker.due(16.0, 20.0, 0.0) == ["please overtake them"]
    assert speaker.due(17.0, 20.0, 0.0) == []
    assert speaker.due(18.0, 60.0, 4.0) == ["slower"]
    assert GuidancePlayer(str(path), "9").due(99.0, 99.0, 0.0) == []
