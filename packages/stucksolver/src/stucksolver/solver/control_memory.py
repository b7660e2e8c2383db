"""Stores the lines of traffic lights and stop signs: a light that is no longer detected is unknown, not gone."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from stucksolver.guard.policy import ControlPolicy
from stucksolver.scene import ControlKind, LightState, Surroundings, TrafficControl
from stucksolver.scene.frenet import RoadFrame, road_frame

BEHIND_M = 85.0
"""Distance behind the front bumper after which a line is dropped (m): more than twice the longest way back (40 m)."""
ASIDE_M = 8.0
"""Distance from the route beyond which a line is not on the route (m): two lanes, as `ScenePolicy.beside_m`."""
RANGE_SHARE = 0.1
"""Error of a line's position, as a share of the distance at its detection. Ours."""
MOST_LINES = 64
"""Maximum number of stored lines, the last ones: a bound on the work of a tick."""
MAY_PASS = frozenset({LightState.GREEN, LightState.OFF})
"""States that do not forbid crossing the line."""


@dataclass(frozen=True)
class _Line:
    """Stop line at a position in the local frame, with its last detections.

    Attributes:
        kind: Kind of the control that requires the stop.
        x_m, y_m: Point at which the route crosses the line (m).
        sure_m: Distance from there within which a detection belongs to this line (m).
        heads: Each light or sign of the line at its last detection.
    """

    kind: ControlKind
    x_m: float
    y_m: float
    sure_m: float
    heads: tuple[TrafficControl, ...]

    @property
    def may_be_passed(self) -> bool:
        """True if no control of the line, at its last detection, forbids to cross it."""
        return self.kind is ControlKind.STOP_SIGN or all(head.state in MAY_PASS for head in self.heads)


@dataclass(frozen=True)
class _Place:
    """Line in the present window of the road, with its distance from the front bumper (m)."""

    distance_m: float
    line: _Line


class ControlMemory:
    """Memory of each detected line until it is well behind the ego, or detected differently.

    Controls have no ids: a line is identified by its kind and its position in the local frame.
    """

    def __init__(self, policy: ControlPolicy | None = None) -> None:
        self._policy = policy or ControlPolicy()
        self._lines: tuple[_Line, ...] = ()

    def controls(self, raw: Surroundings) -> tuple[TrafficControl, ...]:
        """Return the detected controls, and for each vanished control one of unknown state.

        If none has vanished, this is `raw.controls` itself.
        """
        if not raw.controls and not self._lines:
            return raw.controls
        frame, front_s = _front(raw)
        known, off_route = self._here(frame, front_s)
        matched, others = self._matched(raw.controls, known)
        vanished: list[TrafficControl] = []
        lines: list[_Line] = []
        for place, seen in zip(known, matched, strict=True):
            line, missing = self._seen_again(place, seen, frame, front_s)
            lines.append(line)
            vanished += missing
        lines += self._new(others, frame, front_s)
        self._lines = (*off_route, *lines)[-MOST_LINES:]
        return tuple(sorted((*raw.controls, *vanished), key=lambda c: c.distance_m)) if vanished else raw.controls

    def _here(self, frame: RoadFrame, front_s: float) -> tuple[list[_Place], list[_Line]]:
        """Return the lines on this stretch of the route that are not yet well behind, and the lines not on it."""
        here: list[_Place] = []
        off_route: list[_Line] = []
        for line in self._lines:
            s, d, _ = frame.to_road(np.array([[line.x_m, line.y_m]]))
            on_route = abs(float(d[0])) < ASIDE_M and frame.s[0] <= s[0] <= frame.end_m
            if not on_route:
                off_route.append(line)
            elif float(s[0]) - front_s > -BEHIND_M:
                here.append(_Place(float(s[0]) - front_s, line))
        return here, off_route

    @staticmethod
    def _matched(
        controls: Iterable[TrafficControl], known: list[_Place]
    ) -> tuple[list[list[TrafficControl]], list[TrafficControl]]:
        """Return for each known line its detected controls, and the controls at no known line.

        Each control belongs to the nearest line.
        """
        groups: list[list[TrafficControl]] = [[] for _ in known]
        others: list[TrafficControl] = []
        for control in controls:
            away = [
                abs(place.distance_m - control.distance_m) if place.line.kind is control.kind else math.inf
                for place in known
            ]
            k = min(range(len(known)), key=away.__getitem__, default=None)
            if k is not None and away[k] <= known[k].line.sure_m:
                groups[k].append(control)
            else:
                others.append(control)
        return groups, others

    def _seen_again(
        self, place: _Place, seen: list[TrafficControl], frame: RoadFrame, front_s: float
    ) -> tuple[_Line, list[TrafficControl]]:
        """Return the updated line, and its controls that have vanished."""
        line = place.line
        lost = _lost(line.heads, seen)
        if seen:
            line = replace(self._line(seen, frame, front_s), heads=(*seen, *lost))
        distance_m = min((c.distance_m for c in seen), default=place.distance_m)
        # A stack may stop reporting a line as soon as the front is over it. A line that may be crossed then counts as
        # passed.
        ahead_m = 0.0 if line.may_be_passed else -self._policy.over_line_m
        if distance_m < ahead_m:
            return line, []
        return line, [_unknown(head, distance_m) for head in lost]

    def _new(self, controls: list[TrafficControl], frame: RoadFrame, front_s: float) -> list[_Line]:
        """Return the lines of controls that belong to no known line; heads close together share a line."""
        groups: list[list[TrafficControl]] = []
        for control in sorted(controls, key=lambda c: c.distance_m):
            for group in groups:
                near = control.distance_m - group[0].distance_m <= self._policy.same_line_m
                if near and group[0].kind is control.kind:
                    group.append(control)
                    break
            else:
                groups.append([control])
        return [self._line(group, frame, front_s) for group in groups]

    def _line(self, heads: list[TrafficControl], frame: RoadFrame, front_s: float) -> _Line:
        distance_m = min(head.distance_m for head in heads)
        x, y, _ = frame.to_local(np.array([front_s + distance_m]), np.zeros(1))
        sure_m = max(self._policy.same_line_m, RANGE_SHARE * abs(distance_m))
        return _Line(heads[0].kind, float(x[0]), float(y[0]), sure_m, tuple(heads))


def _front(raw: Surroundings) -> tuple[RoadFrame, float]:
    """Return the frame of the road, and the arc length of the front bumper (m)."""
    frame = road_frame(raw.road)
    s, _, _ = frame.to_road(np.array([[raw.ego.x_m, raw.ego.y_m]]))
    return frame, float(s[0]) + raw.ego.length_m / 2


def _lost(before: tuple[TrafficControl, ...], seen: list[TrafficControl]) -> list[TrafficControl]:
    """Return the heads of a line that were detected before and have no counterpart among the present detections.

    Heads with equal states are one signal, so any of them represents all. Heads with different states count each.
    """
    if not seen:
        return list(before)
    if len({(head.state, head.applies) for head in before}) == 1:
        return []
    remaining = list(before)
    changed = []
    for head in seen:
        same = next((k for k, b in enumerate(remaining) if (b.state, b.applies) == (head.state, head.applies)), None)
        if same is None:
            changed.append(head)
        else:
            del remaining[same]
    # A head with a new state is one of those that may have changed. Heads that forbid crossing are kept to the last.
    remaining.sort(key=lambda head: head.state not in MAY_PASS)
    return remaining[len(changed) :]


def _unknown(head: TrafficControl, distance_m: float) -> TrafficControl:
    state = LightState.UNKNOWN if head.kind is ControlKind.TRAFFIC_LIGHT else None
    return head.model_copy(update={"distance_m": distance_m, "state": state})
