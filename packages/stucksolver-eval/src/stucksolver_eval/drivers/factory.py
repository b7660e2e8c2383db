"""Creates drivers by name: `behavior:PROFILE`, `planner:PROFILE`, or a user's agent as `MODULE:CLASS@FILE`."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stucksolver.plugins import plugins
from stucksolver_carla.drivers.behavior import BehaviorDriver, DriverOptions, RoutePoint
from stucksolver_carla.drivers.behavior.profiles import profile_named
from stucksolver_eval.drivers.agent import RouteDriver
from stucksolver_eval.drivers.leaderboard import LeaderboardAgent, is_leaderboard_agent
from stucksolver_eval.drivers.user_agent_driver import UserAgentDriver

if TYPE_CHECKING:
    import carla

    from stucksolver_perception.carla import PerceivedEgo

OURS: dict[str, type[BehaviorDriver]] = {plugin.name: plugin.load() for plugin in plugins("drivers")}
"""Drivers by name: those of installed distributions."""
USUAL = "normal"


class DriverNameError(ValueError):
    """There is no such driver. The message describes the error in its name or its class."""


def check_driver(words: str) -> None:
    """Check that a driver can be created. Raises `DriverNameError`."""
    name, _, rest = words.partition(":")
    if name in OURS:
        try:
            profile_named(rest or USUAL)
        except ValueError as error:
            raise DriverNameError(f"unknown driver: {words!r}: {error}") from error
        return
    _loaded(words)


def carries_sensors(words: str) -> bool:
    """Return True if the driver of this name brings its own sensors. Raises `DriverNameError`."""
    return words.partition(":")[0] not in OURS and is_leaderboard_agent(_loaded(words)[0])


def make_driver(
    words: str,
    client: carla.Client,
    hero: carla.Vehicle,
    carla_map: carla.Map,
    route: Sequence[RoutePoint],
    options: DriverOptions,
    sensed: PerceivedEgo | None = None,
) -> RouteDriver:
    """Create a driver with its route.

    With `sensed`, StuckSolver's drivers use its perception, and so does the one that follows plans for an agent. A
    user's agent gets the hero itself.

    Raises:
        DriverNameError: There is no such driver.
        AgentError: The agent violates its interface.
        Exception: Any exception of the user's agent.
    """
    name, _, profile = words.partition(":")
    ego: Any = sensed or hero
    if name in OURS:
        driver = OURS[name](ego, profile or USUAL, options, carla_map=carla_map)
        driver.set_route(route)
        return driver
    made, config = _loaded(words)
    helper = BehaviorDriver(ego, USUAL, options, carla_map=carla_map)
    if is_leaderboard_agent(made):
        agent = LeaderboardAgent(made, config, client, hero, carla_map)
    else:
        agent = made(hero, carla_map, config) if config else made(hero, carla_map)
    guest = UserAgentDriver(agent, words, helper)
    guest.set_route(route)
    return guest


def _loaded(words: str) -> tuple[Any, str]:
    """Return the class, and the name of its configuration file. Raises `DriverNameError`."""
    words, _, config = words.partition("@")
    module, _, name = words.partition(":")
    if not module or not name:
        raise DriverNameError(
            f"unknown driver: {words!r}. Use behavior or planner, each with :PROFILE, or your own agent as MODULE:CLASS"
        )
    try:
        made = getattr(importlib.import_module(module), name)
    except Exception as error:
        raise DriverNameError(
            f"cannot load driver: {words!r}: {type(error).__name__}: {error}. "
            "Its module must be in the current folder, on PYTHONPATH or installed"
        ) from error
    if not callable(made):
        raise DriverNameError(f"not a class: driver {words!r}. Name a class")
    lacking = [part for part in ("set_route", "run_step") if not hasattr(made, part)]
    if lacking and not is_leaderboard_agent(made):
        raise DriverNameError(
            f"not an agent: driver {words!r} has no {' and no '.join(lacking)}. See examples/own_driver.py"
        )
    return made, config
