"""The weather along a route, interpolated linearly between keys at percentages of its length."""

from __future__ import annotations

from collections.abc import Sequence

import carla

from stucksolver_eval.routes import WeatherKey

STEP_PCT = 1.0
"""Progress between two updates of the weather (%). Ours."""


class Weather:
    """Sets the weather at the start, and updates it as the ego progresses if there are several keys."""

    def __init__(self, world: carla.World, keys: Sequence[WeatherKey]) -> None:
        self._world = world
        self._keys = sorted(keys, key=lambda key: key.route_percentage)
        self._set_at: float | None = None

    def update(self, percentage: float) -> None:
        """Set the weather for this progress on the route (%), if it has changed."""
        if not self._keys or (self._set_at is not None and len(self._keys) == 1):
            return
        if self._set_at is not None and abs(percentage - self._set_at) < STEP_PCT:
            return
        self._set_at = percentage
        weather = carla.WeatherParameters()
        for name, value in between(self._keys, percentage).items():
            if hasattr(weather, name):
                setattr(weather, name, value)
        self._world.set_weather(weather)


def between(keys: Sequence[WeatherKey], percentage: float) -> dict[str, float]:
    """Return the values at a percentage of the route. Before the first and after the last key, that key applies."""
    before = [key for key in keys if key.route_percentage <= percentage] or [keys[0]]
    after = [key for key in keys if key.route_percentage > percentage] or [keys[-1]]
    first, last = before[-1], after[0]
    span = last.route_percentage - first.route_percentage
    share = min(max((percentage - first.route_percentage) / span, 0.0), 1.0) if span > 0 else 0.0
    return {name: value + share * (last.values.get(name, value) - value) for name, value in first.values.items()}
