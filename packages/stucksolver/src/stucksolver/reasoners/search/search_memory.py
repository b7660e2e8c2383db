"""Remembers that a search found nothing, so that it is not repeated while nothing that matters has changed."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass

from stucksolver.reasoners.search.plan_search import SearchResult
from stucksolver.scene import Scene, SceneObject

REMEMBERED_S = 10.0
"""Time after which the search is repeated in any case (s). Ours: a tick of the wait for what has just stopped."""
STANDS_MPS = 0.2
"""An object is stationary if it is slower (m/s). Traffic does not matter: a plan that waits for it is a result."""
PLACE_M = 0.2
"""Differences of places that do not matter (m). Ours."""
SIGHT_M = 4.0
"""Differences of sight distances that do not matter (m). Ours."""
NEAR_M = 60.0
"""Objects farther away do not matter (m). Ours: beyond the reach of a plan."""
STOOD_S = (1.0, 3.0, 10.0, 30.0, 60.0)
"""Times at rest after which an object may be passed, or counts as parked (s): those of guard and duties."""


@dataclass
class SearchMemory:
    """The last search without a plan, with what it depended on. One for each reasoner."""

    _seen: Hashable = None
    _at_s: float = -math.inf
    _result: SearchResult | None = None

    def recall(self, scene: Scene, search: Callable[[], SearchResult], asked: Hashable) -> SearchResult:
        """Return the remembered result if nothing that matters has changed, else that of a new search.

        Args:
            scene: The scene.
            search: Runs the search.
            asked: What else the search depends on.
        """
        seen = (asked, *_what_matters(scene))
        if self._result is not None and seen == self._seen and 0.0 <= scene.time_s - self._at_s < REMEMBERED_S:
            return self._result
        result = search()
        self._seen, self._at_s = seen, scene.time_s
        self._result = result if result.best is None else None
        return result


def _what_matters(scene: Scene) -> tuple[Hashable, ...]:
    """Return the ego's place, what is stationary, what is seen, what is offered, and what has been tried."""
    ego = scene.ego
    reading = None if scene.guidance is None else scene.guidance.reading
    return (
        (ego.lane_id, _steps(ego.lateral_offset_m, PLACE_M), _steps(ego.speed_mps, STANDS_MPS), ego.zone),
        frozenset(_stationary(o) for o in scene.objects if _is_near(o) and math.hypot(o.vx_mps, o.vy_mps) < STANDS_MPS),
        tuple((lane.id, lane.may_enter, _steps(lane.sight_ahead_m, SIGHT_M)) for lane in scene.lanes),
        tuple((c.kind, c.state, c.applies, _steps(c.distance_m, PLACE_M)) for c in scene.controls),
        tuple(behavior.name for behavior in scene.behaviors),
        None if reading is None else reading.model_dump_json(),
        scene.claims,
        scene.attempts,
    )


def _is_near(o: SceneObject) -> bool:
    return math.hypot(o.x_m, o.y_m) < NEAR_M


def _stationary(o: SceneObject) -> Hashable:
    stood = sum((o.stationary_s or 0.0) >= limit_s for limit_s in STOOD_S)
    place = (_steps(o.x_m, PLACE_M), _steps(o.y_m, PLACE_M), _steps(o.yaw_rad, PLACE_M))
    return (o.id, o.kind, *place, o.hazard_lights, o.emergency_lights, o.door_open, stood)


def _steps(value: float | None, size: float) -> int | None:
    return None if value is None or not math.isfinite(value) else round(value / size)
