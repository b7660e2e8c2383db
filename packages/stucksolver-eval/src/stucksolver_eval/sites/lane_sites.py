"""Sites along a lane, away from junctions. The lengths are ours."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from stucksolver_eval.sites.lane_requirements import Fits
from stucksolver_eval.sites.lane_walk import Path, Town, bend_deg
from stucksolver_eval.sites.movements import JunctionMovement
from stucksolver_eval.sites.site import Site

_STRAIGHT_DEG = 12.0
"""Largest change of heading of a straight stretch (degrees)."""
_STEP_M = 20
"""Distance between two candidate sites (m)."""
_MARK_EVERY_M = 60
"""Distance between marks of a route (m)."""
_MARGIN_M = 6
"""Distance of a route's ends from the ends of the lane (m)."""
_LONGEST_M = 280
"""Longest route after the trigger (m)."""


@dataclass(frozen=True)
class LaneSites:
    """Finds all sites on a map at which a lane satisfies a type's requirements, every 20 m of each lane."""

    fits: Fits
    after_m: int = 140
    """Length of free lane after the trigger."""
    before_m: int = 28
    """Distance from the route's start to the trigger, on the same road."""
    behind_m: int = 0
    """Length of lane that must exist before the route's start."""
    direct: bool = True
    """True if the stretch must be straight."""

    def __call__(self, town: Town, ways: list[JunctionMovement]) -> Iterator[Site]:
        for lane in town.lanes:
            last = len(lane) - self.after_m - _MARGIN_M
            for start in range(self.behind_m + self.before_m + _MARGIN_M, last + 1, _STEP_M):
                stretch = lane[start : start + self.after_m]
                if self.direct and bend_deg(stretch) > _STRAIGHT_DEG:
                    continue
                if self.fits(town, stretch):
                    yield self._site(town, lane, start)

    def _site(self, town: Town, lane: Path, start: int) -> Site:
        first, trigger = start - self.before_m, lane[start]
        path = lane[first : min(len(lane) - _MARGIN_M, first + _LONGEST_M)]
        name = f"{trigger.road_id}/{trigger.lane_id}"
        marks = (*path[:-_MARK_EVERY_M:_MARK_EVERY_M], path[-1])
        return Site(town, name, f"{name}@{start}", path, marks, trigger, free_m=len(lane) - start - _MARGIN_M)
