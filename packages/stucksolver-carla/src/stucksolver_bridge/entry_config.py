"""Reads the entry's configuration: a JSON file with a few fields. The checks need no package, for Python 3.7."""

from __future__ import annotations

import json
import os
from typing import Any, NamedTuple

from stucksolver_bridge.solver_exchange import limit_of

NONE, TIMERS = "none", "timers"
AGENT, PLANNER = "agent", "planner"
PRIVILEGED, SENSORS = "privileged", "sensors"


class ConfigError(ValueError):
    """A configuration file is invalid; the message names file, field and remedy."""


class Config(NamedTuple):
    """Fields of the configuration file: the driver, its recovery, perception and output folders."""

    recovery: str = NONE
    """`none`: the driver alone; `timers`: fixed actions, one after the other; otherwise the name of a reasoner:
    `openai:MODEL`, `recorded:FOLDER`."""
    reasoner: str | None = None
    """A second reasoner, for the ladder's rung `model`."""
    python: str = ""
    """A Python 3.10 to 3.12 in which stucksolver is installed; needed if a reasoner is used."""
    path: str = ""
    """Folder in which that Python finds stucksolver, if it is not installed there."""
    behavior: str = "normal"
    """The driver's style: `cautious`, `normal` or `aggressive`."""
    driver: str = AGENT
    """`agent`: CARLA's BehaviorAgent; `planner`: the built-in planner, if the evaluator's Python has stucksolver."""
    obstacles: bool = True
    """True to pass the stationary objects around the ego to BehaviorAgent, which requests only vehicles and walkers."""
    ladder: str = "evaluation"
    """Name of the ladder."""
    clock: str = "lockstep"
    """Simulated time that an answer takes: `lockstep`, `latency:SECONDS` or `latency:measured`."""
    answer_limit_s: float = 120.0
    """Wall time for which the world waits for an answer of the solver (s); after that the route ends with an error."""
    guidance: str = ""
    """A guidance script (docs/evaluate.md): the utterances of a passenger on each route."""
    perception: str = PRIVILEGED
    """`privileged`: driver and solver get the client's ground truth; `sensors`: they get data of the declared sensors.
    With `sensors`, both run in the solver's process, and `driver` must be `planner`."""
    rig: str = ""
    """The calibration of these sensors, a file like `stucksolver_perception/rig.toml`; empty: that file."""
    sensors: bool = True
    """True to declare the sensors of Bao and Li 2025 (arXiv:2510.26023), which only perception `sensors` uses. False
    saves the rendering."""
    metrics: str = ""
    """Folder for Bench2Drive's `metric_info.json`, with one folder for each route; empty: $SAVE_PATH."""
    record: str = ""
    """Folder for the solver's record of each intervention (docs/record.md), with one folder for each route."""
    events: str = ""
    """Folder for the events of each route, as lines of JSON."""


def read_config(argument: str) -> tuple[Config, str]:
    """Return the configuration and the name of the route's folder, from the evaluator's argument.

    The argument is the file's path, followed by a plus sign and a name for each route up to this one; the last name is
    that of this route. The path itself may contain plus signs.
    """
    path, names = _split(argument)
    try:
        with open(path, encoding="utf-8") as file:
            fields = json.load(file)
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror}; give a JSON file as --agent-config") from error
    except ValueError as error:
        raise ConfigError(f"{path}: invalid JSON ({error}); see docs/integrate.md") from error
    if not isinstance(fields, dict):
        raise ConfigError(f"{path}: expected an object with fields; see docs/integrate.md")
    return checked(fields, path), names[-1] if names else "route"


def _split(argument: str) -> tuple[str, list[str]]:
    """Return the path and the names. The path is the longest prefix that is a file, or all up to the first plus."""
    parts = argument.split("+")
    for end in range(len(parts), 0, -1):
        path = "+".join(parts[:end])
        if os.path.isfile(path):
            return path, parts[end:]
    return parts[0], parts[1:]


def _check_limit(name: str, value: Any, path: str) -> None:
    try:
        limit_of(value, name)
    except ValueError as error:
        raise ConfigError(f"{path}: {error}") from error


def _check_sensor_mode(config: Config, path: str) -> None:
    """Check the fields that sensor-based perception requires. Raises `ConfigError`."""
    if not config.sensors:
        raise ConfigError(f"{path}: perception {SENSORS!r} requires the sensors; leave 'sensors' at true")
    if config.driver != PLANNER:
        raise ConfigError(
            f"{path}: driver {config.driver!r} reads every actor's position from the client; "
            f"with perception {SENSORS!r} set 'driver' to {PLANNER!r}"
        )
    if config.recovery == TIMERS:
        raise ConfigError(
            f"{path}: recovery {TIMERS!r} is not available with perception {SENSORS!r}; use {NONE} or a reasoner"
        )
    if not config.python:
        remedy = "name a Python 3.10 to 3.12 that has stucksolver with its extra 'perception'"
        raise ConfigError(f"{path}: perception {SENSORS!r} requires the field 'python': {remedy}")
    if config.rig and not os.path.isfile(config.rig):
        raise ConfigError(
            f"{path}: rig file not found: {config.rig!r}; give the calibration of the sensors, or leave it out"
        )


def checked(fields: dict[str, Any], path: str) -> Config:
    """Return the configuration, checked. Raises `ConfigError`."""
    defaults = Config()
    unknown = sorted(set(fields) - set(Config._fields))
    if unknown:
        raise ConfigError(f"{path}: unknown field {unknown[0]!r}; choose from {', '.join(Config._fields)}")
    for name, value in fields.items():
        field_type = type(getattr(defaults, name))
        if field_type is float:
            _check_limit(name, value, path)
        elif not isinstance(value, bool if field_type is bool else str) and not (name == "reasoner" and value is None):
            raise ConfigError(
                f"{path}: {name} must be {'true or false' if field_type is bool else 'a string'}, not {value!r}"
            )
    config = Config(**fields)
    if config.recovery not in (NONE, TIMERS) and not config.python:
        remedy = "name a Python 3.10 to 3.12 that has stucksolver"
        raise ConfigError(f"{path}: recovery {config.recovery!r} requires the field 'python': {remedy}")
    if config.driver not in (AGENT, PLANNER):
        raise ConfigError(f"{path}: unknown driver {config.driver!r}; use {AGENT} or {PLANNER}")
    if config.perception not in (PRIVILEGED, SENSORS):
        raise ConfigError(f"{path}: unknown perception {config.perception!r}; use {PRIVILEGED} or {SENSORS}")
    if config.perception == SENSORS:
        _check_sensor_mode(config, path)
    elif config.rig:
        raise ConfigError(
            f"{path}: 'rig' is the calibration of perception {SENSORS!r}; leave it out, or set perception"
        )
    if config.python and not os.access(config.python, os.X_OK):
        raise ConfigError(f"{path}: python {config.python!r} is not an executable file")
    return config
