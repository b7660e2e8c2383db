"""Returns the lines of a guidance script when they are due (docs/evaluate.md describes the format)."""

from __future__ import annotations

import json
from typing import Any

STOPPED_MPS = 0.1
"""Speed below which the ego counts as stopped (m/s). Ours."""


class GuidancePlayer:
    """The lines for one route, each in its first wording. Call `due` once per tick."""

    def __init__(self, path: str, route_id: str) -> None:
        with open(path, encoding="utf-8") as file:
            script = json.load(file)
        self._pending: list[dict[str, Any]] = list(script.get("routes", {}).get(route_id, ()))
        self._moved_s = 0.0

    def due(self, time_s: float, place_m: float, speed_mps: float) -> list[str]:
        """Return the lines that are due at this tick."""
        if speed_mps >= STOPPED_MPS:
            self._moved_s = time_s
        values = {"time_s": time_s, "place_m": place_m, "stopped_s": time_s - self._moved_s}
        due_lines = [
            line for line in self._pending if all(values[name] >= threshold for name, threshold in line["when"].items())
        ]
        self._pending = [line for line in self._pending if line not in due_lines]
        return [str(line["say"][0]) for line in due_lines]
