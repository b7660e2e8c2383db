"""Staged scenes: actors without physics, placed anew for each image, in a given weather; many drives in parallel."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Protocol, TypeVar

import carla
import numpy as np

from lab.perception.recording.far_scene_poses import AWAY_M

DAY = ("ClearNoon", "CloudyNoon", "WetNoon", "ClearSunset", "WetCloudySunset")
RAIN = ("MidRainyNoon", "HardRainNoon", "MidRainSunset", "SoftRainSunset")
NIGHT = ("ClearNight", "CloudyNight", "WetNight")
RAIN_NIGHT = ("MidRainyNight", "HardRainNight")
FOG_DENSITIES = (15.0, 30.0, 50.0, 70.0)
"""Values of `carla.WeatherParameters.fog_density` (percent). Ours."""
KINDS_OF_WEATHER = ("day", "day", "day", "rain", "night", "night", "rain_night", "fog")
"""Kinds of weather; each entry has the same probability. Ours."""
CLIENT_LIMIT_S = 60.0
"""Timeout of the client's calls (s). Ours."""


class StagedDrive(Protocol):
    """One town in one weather."""

    @property
    def folder(self) -> Path:
        """Folder of the recording."""

    @property
    def town(self) -> str:
        """The town's name."""


Drive = TypeVar("Drive", bound=StagedDrive)


def spawn_away(world: Any, blueprint: Any, number: int) -> Any:
    """Spawn an actor without physics, far away and out of sight; `number` separates actors."""
    place = carla.Transform(carla.Location(x=AWAY_M + 20.0 * number, y=-AWAY_M))
    actor = world.spawn_actor(blueprint, place)
    actor.set_simulate_physics(False)
    return actor


def draw_blueprint(random: np.random.Generator, blueprints: Sequence[Any]) -> Any:
    """Return a random blueprint, with a random color if it has several."""
    blueprint = blueprints[int(random.integers(len(blueprints)))]
    if blueprint.has_attribute("color"):
        colors = blueprint.get_attribute("color").recommended_values
        blueprint.set_attribute("color", colors[int(random.integers(len(colors)))])
    return blueprint


def drawn_weather(random: np.random.Generator) -> tuple[str, carla.WeatherParameters]:
    """Draw a kind of weather and its parameters."""
    sort = KINDS_OF_WEATHER[int(random.integers(len(KINDS_OF_WEATHER)))]
    presets = {"day": DAY, "rain": RAIN, "night": NIGHT, "rain_night": RAIN_NIGHT, "fog": DAY}[sort]
    weather = getattr(carla.WeatherParameters, presets[int(random.integers(len(presets)))])
    chosen = copied(weather)
    if sort == "fog":
        chosen.fog_density = float(random.choice(FOG_DENSITIES))
    return sort, chosen


def copied(weather: carla.WeatherParameters) -> carla.WeatherParameters:
    """Return a copy: the presets are shared."""
    chosen = carla.WeatherParameters()
    for name in (
        text for text in dir(weather) if not text.startswith("_") and isinstance(getattr(weather, text), float)
    ):
        setattr(chosen, name, getattr(weather, name))
    return chosen


def options(
    description: str, towns: Sequence[str], *, drives: int, scenes: int, scenes_help: str
) -> argparse.ArgumentParser:
    """Return the options that all recordings of staged scenes have, with these defaults."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--out", type=Path, required=True, help="folder for the recordings")
    parser.add_argument("--drives", type=int, default=drives)
    parser.add_argument("--scenes", type=int, default=scenes, help=scenes_help)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--towns", default=",".join(towns), help="towns to use in turn, separated by commas")
    parser.add_argument("--maps", default=os.environ.get("STUCKSOLVER_MAPS"), help="folders with towns")
    return parser


def record_all(record: Callable[[Drive], int], drives: Sequence[Drive], jobs: int) -> int:
    """Record drives in parallel, and report each; return 1 if any failed. A failed one does not stop the others."""
    failed = 0
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        waiting = {pool.submit(record, drive): drive for drive in drives}
        for done, future in enumerate(as_completed(waiting), 1):
            drive = waiting[future]
            error = future.exception()
            failed += error is not None
            result = f"{future.result()} pictures" if error is None else f"failed: {error}"
            print(f"{done}/{len(drives)} {drive.folder.name} {drive.town}: {result}", flush=True)
    return 1 if failed else 0
