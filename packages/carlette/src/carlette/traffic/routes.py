"""Where each car goes: the lanes ahead of it, and their points as rows of arrays."""

from __future__ import annotations

from zlib import crc32

import numpy as np

from carlette.traffic.grid import Ints
from carlette.traffic.lanes import LaneGraph

AHEAD_POINTS = 100
"""How far cars look, in lane points of about a metre."""
RENEW_POINTS = 40
"""After so many points a car's row is written anew."""
ROW_POINTS = AHEAD_POINTS + RENEW_POINTS + 20


class Route:
    """The lanes of one car, from the one it is on, with the way to each lane's begin in metres."""

    def __init__(self, graph: LaneGraph, point: int, chance: str) -> None:
        self.lanes = [int(graph.lane[point])]
        self.starts = [-float(graph.along[point])]
        """Metres on the car's own count, which begins with 0 where it was taken over."""
        self.chance = chance
        self.turns = 0

    def extend(self, graph: LaneGraph, until_m: float) -> None:
        """Chooses lanes by the seed until the route is known up to there, and to the end of a junction."""
        while self.starts[-1] < until_m or graph.inside[self.lanes[-1]]:
            last = self.lanes[-1]
            choices = graph.after[last]
            if not choices:
                return
            draw = crc32(f"{self.chance} {self.turns} {last}".encode())
            self.turns += 1
            lane = choices[draw % len(choices)]
            end, begin = graph.first[last + 1] - 1, graph.first[lane]
            joint = float(np.hypot(*(graph.place[begin, :2] - graph.place[end, :2])))
            self.starts.append(self.starts[-1] + float(graph.along[end]) + joint)
            self.lanes.append(lane)

    def forget(self, lane: int) -> None:
        """Drops what lies before `lane`."""
        while self.lanes[0] != lane:
            del self.lanes[0], self.starts[0]

    def points(self, graph: LaneGraph, point: int) -> Ints:
        """`ROW_POINTS` lane points from `point` of the first lane on; the last is repeated where the way ends."""
        parts = [np.arange(point, graph.first[self.lanes[0] + 1])]
        parts += [np.arange(graph.first[lane], graph.first[lane + 1]) for lane in self.lanes[1:]]
        row = np.concatenate(parts)[:ROW_POINTS]
        return np.pad(row, (0, ROW_POINTS - len(row)), mode="edge")

    def next_junction(self, graph: LaneGraph, after_m: float) -> tuple[float, float, tuple[int, ...]]:
        """Begin, end (m) and lanes of the first junction that begins after `after_m`; infinite where there is none."""
        begin = np.inf
        inside: list[int] = []
        for lane, start in zip(self.lanes, self.starts, strict=True):
            if graph.inside[lane] and (start > after_m or inside):
                begin = begin if inside else start
                inside.append(lane)
            elif inside:
                return begin, start, tuple(inside)
        return (begin, np.inf, tuple(inside)) if inside else (np.inf, np.inf, ())
