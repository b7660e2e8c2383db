"""The speed of a vehicle that sensors have just found: no lower than the pace of those who drove there before.

At the edge of the LiDAR's grid, speeds are measured too low at first: 10 to 14 m/s of 20. Whoever sets off before such
a vehicle because it seems slow gets in its way.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stucksolver.stacks.driver.perception import FIRST_FAR_ID

if TYPE_CHECKING:
    from stucksolver.stacks.driver.give_way import OtherOnWay
    from stucksolver.stacks.driver.meeting_ways import MeetingWay

NEW_S = 0.7
"""A vehicle is new for so long after it was first seen on a way (s)."""
PACE_S = 5.0
"""The pace of a way is forgotten when nobody has driven there for so long (s)."""


class LanePace:
    """Remembers how fast vehicles drove on the ways of one junction."""

    def __init__(self) -> None:
        self._since: dict[tuple[int, int], float] = {}
        self._paces: dict[int, tuple[float, float]] = {}
        """By way: when somebody last drove there (s), and the median speed then (m/s)."""

    def of(self, seen: Sequence[tuple[MeetingWay, OtherOnWay]], now_s: float) -> list[tuple[MeetingWay, OtherOnWay]]:
        """Return them, the new ones with the pace of their way (m/s) if they seem slower."""
        self._since = {(id(way), one.actor_id): self._since.get((id(way), one.actor_id), now_s) for way, one in seen}
        speeds: dict[int, list[float]] = {}
        for way, one in seen:
            if one.actor_id < FIRST_FAR_ID and not self._is_new(way, one, now_s):
                speeds.setdefault(id(way), []).append(one.speed)
        self._paces |= {way: (now_s, float(np.median(some))) for way, some in speeds.items()}
        return [
            (way, self._at_pace(id(way), one, now_s) if self._is_new(way, one, now_s) else one) for way, one in seen
        ]

    def _is_new(self, way: MeetingWay, one: OtherOnWay, now_s: float) -> bool:
        return now_s - self._since[id(way), one.actor_id] < NEW_S

    def _at_pace(self, way: int, one: OtherOnWay, now_s: float) -> OtherOnWay:
        since_s, pace = self._paces.get(way, (now_s, 0.0))
        return one._replace(speed=max(one.speed, pace)) if now_s - since_s < PACE_S else one
