"""Gives way where others cross or join the route: wait before the junction for a gap, then go through.

The drives of the ego and of the others along their routes are predicted in steps. If the boxes come too near, the ego
waits. It never stops where the ways meet. CARLA's world frame, metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import ClassVar, NamedTuple

import carla
import numpy as np

from stucksolver.scene.boxes import separation
from stucksolver.stacks.driver.behavior import Profile, toward_speed
from stucksolver.stacks.driver.concerns import Pace
from stucksolver.stacks.driver.lane_graph import LaneKey
from stucksolver.stacks.driver.lane_pace import LanePace
from stucksolver.stacks.driver.meeting_ways import Meeting, MeetingWay
from stucksolver.stacks.driver.path import Array, Path
from stucksolver.stacks.driver.perception import FIRST_FAR_ID, NearbyBodies
from stucksolver.stacks.driver.vehicle_model import VehicleModel

BRISK = Pace(1.3, 1.2)
"""How to drive into a gap."""
STEP_S = 0.1
HORIZON_S = 9.0
JOINED_S = 4.0
"""From this time after the ego has joined a flow, nobody behind has to brake for it."""
_LOOKS_M = 20.0
_LOOKS_S = 4.0
_LEAST_MPS = 0.5
CREEPS_MPS = 1.0
"""An ego by sensors may creep up to the others' way: it sets off for a gap, sees that there is none, and knows its own
place to some decimetres only. If it is slower than this (m/s) ...
"""
NOSE_M = 1.0
"""... and no further in that way than this (m), it still waits. If it gives up no further than this past the line
before a junction or ramp, it stays there and has the whole ramp to run up.
"""
SETTLED_S = 0.15
"""By sensors, a standing ego sets off when the way has been free for so long: two looks. One that has set off gives up
when it has not been free for so long: a single noisy speed would take the best gap away.
"""
LETS_PASS_S = 0.5
"""By sensors, an ego that has set off and is early lets those pass who will be past if it comes later by no more than
this (s). It does not give up its gap for them: in a stream the next one would be too short.
"""
STREAM = 3
"""So many vehicles on one way are a stream, which drives at one speed."""
NOISE_MPS = 1.5
"""By sensors each of their speeds is off by up to this (m/s): over a drive of four seconds, by a car's length."""
SENSED_HORIZON_S = 12.0
"""By sensors the drives are predicted for so long: up to a ramp's end, and `JOINED_S` more. Else a gap on a ramp of six
seconds would seem long enough until the ego is half-way down, and can go neither on nor back.
"""
FASTER_MPS = 2.0
"""By sensors, a stream that is faster than the ego's own speed by more than this (m/s) is joined at its pace, ..."""
FASTEST_MPS = 22.0
"""... up to this (m/s)."""
_ON_WAY_M = 1.5
_ALONG_COS = math.cos(math.radians(45.0))
LOOKING_MPS = 5.0
"""Speed before a turn across possible traffic: slow enough to see and still be able to wait."""
_A_TURN_MPS = 9.0
_STOPPING_MPS2 = 4.0
"""Someone who would have to brake harder than this does not stop."""
_SLOWING_MPS2 = 3.0
_HARD_MPS2 = 5.0
FULL_MPS2 = 7.0
_AT_THE_LINE_M = 3.0
_EARLY = 0.8
"""The ego may need only this share of the predicted time."""
_SHOWN_M, _ENOUGH = 15.0, 2
"""If this many vehicles from a lane took other ways and none took this one, those farther away than this from the
junction are not expected to take it.
"""
START_LAG_S = 0.3
_MARGIN_M = 0.3


class Margin(NamedTuple):
    """What is kept free before and behind the others, in metres and in seconds of their drive."""

    before_m: float
    before_s: float
    behind_m: float
    behind_s: float


TO_GO = Margin(1.0, 0.8, 0.5, 0.2)
PATIENCE_S = 20.0
"""After this wait the ego accepts its smallest gap: accepted gaps shrink with the time waited."""
AFTER_WAITING = Margin(0.5, 0.3, 0.3, 0.1)
TO_GO_ON = Margin(0.5, 0.1, 0.0, 0.0)
"""For a vehicle that has set off: smaller, so that it does not hesitate."""


class LeadVehicle(NamedTuple):
    """A vehicle on a joining way, as if it were on the route: bumper gap (m, negative abreast), speed (m/s)."""

    gap_m: float
    speed: float


class GiveWayDecision(NamedTuple):
    """The result of `GiveWay` for one tick."""

    wait_m: float | None
    """Distance from the front bumper to the waiting place (m); None if the way is free."""
    passing: frozenset[int]
    """Ids of those who will be out of the way in time, although they may be in it now."""
    look_m: float | None = None
    """Distance from the front bumper to where to be slow enough to look (m)."""
    leader: LeadVehicle | None = None
    """The vehicle behind which to join the flow."""


FREE = GiveWayDecision(None, frozenset())


class Moving(NamedTuple):
    """The ego's speed along its route, and its speed if nothing held it back (m/s)."""

    speed: float
    top_mps: float


class GiveWay:
    """Remembers, for one route, at which junction the ego has set off."""

    shown_m: ClassVar[float] = _SHOWN_M
    """See `Habits`."""
    waits_with_its_nose_in: ClassVar[bool] = False
    """True if it waits as by sensors, see `NOSE_M`, with ground truth as well."""

    def __init__(
        self,
        meetings: Sequence[Meeting],
        profile: Profile,
        model: VehicleModel,
        pace: Pace = BRISK,
        *,
        sensed: bool = False,
    ) -> None:
        """`sensed`: the ego's place and the others' are known by sensors; see `NOSE_M` and `SETTLED_S`."""
        self._sensed = sensed
        self._clear_s = self._met_s = 0.0
        self._due = list(meetings)
        self.pace = pace
        """How to drive into a gap."""
        self._profile = replace(profile, acceleration=profile.acceleration + pace.more_mps2)
        self._model = model
        self._going: Meeting | None = None
        self._waited_s = 0.0
        self._habits = Habits(self.shown_m)
        self._pace_before, self._now_s = LanePace(), 0.0
        self.flow_mps = 0.0
        """By sensors: pace of a faster stream that the ego joins at the junction ahead (m/s); 0 without one."""

    @property
    def waits_at(self) -> tuple[Meeting | None, float]:
        """The junction ahead, if any, and how long it has waited there so far (s)."""
        return (self._due[0] if self._due else None), self._waited_s

    @property
    def going(self) -> bool:
        """True if it has set off in a gap."""
        return self._going is not None

    def stay(self) -> None:
        """Something else stops the ego: it has not set off."""
        self._going = None

    def look(self, line: Path, s: float, motion: Moving, around: NearbyBodies, dt_s: float) -> GiveWayDecision:
        """Decide whether the ego must wait, with its centre at arc length `s` of the route's `line`.

        `dt_s` is the time since the last look (s).
        """
        speed = motion.speed
        half = self._model.half_length
        front = s + half
        self._now_s += dt_s
        self._forget(s)
        if not self._due or self._due[0].wait_s - front > _LOOKS_M + _LOOKS_S * speed:
            return FREE
        meeting = self._due[0]
        coming = self._coming(meeting, around)
        own = self._drive(line, s, speed, self._top_mps(motion, coming))
        held = self._sensed and can_stop(speed, min(meeting.wait_s + NOSE_M, meeting.first_s) - front, _HARD_MPS2)
        place_s = meeting.wait_s if held or front <= meeting.wait_s else meeting.first_s
        room = place_s - front
        if not held and self._must_go(speed, room):
            self._going = meeting
            return self._gone(meeting, own.judge(coming, TO_GO_ON), front, speed)
        room = max(room, 0.0) if self._sensed else room
        going = self._going is meeting
        found = own.judge(coming, TO_GO_ON if going else self._margin())
        if self._sensed and going and found.met and found.pass_soon:
            return GiveWayDecision(room, frozenset())
        self._clear_s = 0.0 if found.met else self._clear_s + dt_s
        self._met_s = self._met_s + dt_s if found.met else 0.0
        if self._sensed and going and 0.0 < self._met_s < SETTLED_S:
            return GiveWayDecision(None, found.passing, None, found.leader)
        if self._sensed and going and found.met and not own.judge(_not_yet_there(coming), self._margin()).met:
            # It set off faster than foretold behind someone who is passing: giving up would take the gap away.
            return GiveWayDecision(room, frozenset())
        if self._sensed and not going and speed < _LEAST_MPS and not found.met and self._clear_s < SETTLED_S:
            return GiveWayDecision(room, frozenset())
        self._waited_s += dt_s if speed < _LEAST_MPS and room < _AT_THE_LINE_M else 0.0
        decided = room < _AT_THE_LINE_M or not can_stop(speed, room, self._profile.deceleration)
        self._going = None if found.met or not (going or decided) else meeting
        if found.met:
            return GiveWayDecision(room, frozenset())
        look_m = room if front <= meeting.wait_s and _asks_to_look(meeting, line) else None
        return GiveWayDecision(None, found.passing, look_m, found.leader)

    def _forget(self, s: float) -> None:
        """Drop the junctions that an ego with its centre at `s` has left."""
        while self._due and s - self._model.half_length > self._due[0].last_s:
            self._due.pop(0)
            self._going, self._waited_s, self._habits = None, 0.0, Habits(self.shown_m)

    def _coming(self, meeting: Meeting, around: NearbyBodies) -> list[tuple[MeetingWay, OtherOnWay]]:
        """Return those who come by a junction's ways and are not expected to wait or to turn off."""
        others = _moving(around)
        under_way = [(way, one) for way in meeting.ways for one in on_way(way, others)]
        self._habits.see([seen for seen in under_way if not (self._sensed and seen[1].actor_id >= FIRST_FAR_ID)])
        if self._sensed:
            paced = self._pace_before.of(under_way, self._now_s)
            # Who has set off gives up for what is measured: a fast car's trailing returns may be a new track, too, and
            # of whom only the camera sees just the nearest possible place is told, up to 20 m before the true one.
            measured = [seen for seen in under_way if seen[1].actor_id < FIRST_FAR_ID]
            under_way = of_one_pace(measured if self.going else paced)
        return [(way, one) for way, one in under_way if _comes(way, one) and self._habits.expect(way, one)]

    def _drive(self, line: Path, s: float, speed: float, top_mps: float) -> Drive:
        """Return the ego's drive if it goes now."""
        horizon_s = SENSED_HORIZON_S if self._sensed else HORIZON_S
        gone = foretold(line, s, speed, top_mps, self._profile, self.pace.bends, self._lag_s(), horizon_s=horizon_s)
        return Drive(line, gone, self._model, followers=not self._sensed)

    def _must_go(self, speed: float, room: float) -> bool:
        """True if the ego can no longer stop before the others' way, `room` metres ahead; see `NOSE_M`."""
        creeps = (self._sensed or self.waits_with_its_nose_in) and speed < CREEPS_MPS and room > -NOSE_M
        return not creeps and not can_stop(speed, room, _HARD_MPS2)

    def _lag_s(self) -> float:
        """Return how long a standing ego takes to set off (s).

        None by sensors for one that has set off: it would seem too late at every look, and give up, as the gap that it
        takes after a long wait is hardly longer than the one in which it goes on.
        """
        return 0.0 if self._sensed and self.going else START_LAG_S

    def _top_mps(self, motion: Moving, coming: Sequence[tuple[MeetingWay, OtherOnWay]]) -> float:
        """Return the ego's highest speed with the present traffic (m/s)."""
        pace = pace_of_flow(coming)
        fast = self._sensed and motion.top_mps + FASTER_MPS < pace < math.inf
        self.flow_mps = min(pace, FASTEST_MPS) if fast else 0.0
        return self.flow_mps or min(motion.top_mps, pace)

    def _gone(self, meeting: Meeting, found: Met, front: float, speed: float) -> GiveWayDecision:
        """Past the waiting place, still brake for whoever comes regardless, but not in another's way."""
        rooms = [way.route_meets_s - front for way in found.met if self._may_stop_before(way, meeting, front)]
        room = min(rooms, default=-1.0)
        stops = can_stop(speed, room, FULL_MPS2)
        return GiveWayDecision(room, frozenset()) if stops else GiveWayDecision(None, found.passing, None, found.leader)

    def _may_stop_before(self, way: MeetingWay, meeting: Meeting, front: float) -> bool:
        if way.route_meets_s <= front:
            return False
        rear = way.route_meets_s - 2.0 * self._model.half_length - 1.0
        first = [one for one in meeting.ways if one.goes_first and one is not way]
        return not way.joins or not any(
            one.route_meets_s < way.route_meets_s and one.route_parts_s > rear for one in first
        )

    def _margin(self) -> Margin:
        share = min(self._waited_s / PATIENCE_S, 1.0)
        return Margin(*(a + share * (b - a) for a, b in zip(TO_GO, AFTER_WAITING, strict=True)))


def can_stop(speed: float, room: float, deceleration: float) -> bool:
    """True if there is room (m) to stop from a speed (m/s) with that deceleration (m/s²)."""
    return room >= 0.0 and speed * speed <= 2.0 * deceleration * room


def _not_yet_there(coming: Sequence[tuple[MeetingWay, OtherOnWay]]) -> list[tuple[MeetingWay, OtherOnWay]]:
    """Return them without those whose front is where their way crosses the route, or past that."""
    return [(way, one) for way, one in coming if way.joins or one.s + one.half_length < way.meets_s]


class Habits:
    """The ways that traffic from each lane has been seen to take at one junction.

    A vehicle nearer than `shown_m` to the junction may still take any of them.
    """

    def __init__(self, shown_m: float = _SHOWN_M) -> None:
        self._shown_m = shown_m
        self._took: dict[LaneKey, dict[int, MeetingWay]] = {}

    def see(self, seen: Sequence[tuple[MeetingWay, OtherOnWay]]) -> None:
        """Note who is where the ways meet."""
        for way, other in seen:
            if way.meets_s < other.s < way.parts_s:
                self._took.setdefault(way.approach, {})[other.actor_id] = way

    def expect(self, way: MeetingWay, other: OtherOnWay) -> bool:
        """True if the vehicle may take this way, as far as one can tell."""
        took = self._took.get(way.approach, {}).values()
        near = way.inside_s - other.s - other.half_length < self._shown_m
        return near or len(took) < _ENOUGH or any(one is way for one in took)


class Met(NamedTuple):
    """Whom the ego would meet."""

    met: tuple[MeetingWay, ...]
    """The ways on which it would meet them."""
    passing: frozenset[int]
    leader: LeadVehicle | None
    pass_soon: bool = False
    """True if all of those whom it would meet will be past if it comes a little later; see `LETS_PASS_S`."""


def _moving(around: NearbyBodies) -> NearbyBodies:
    return around.part((np.hypot(around.vx, around.vy) > _LEAST_MPS) & ~around.is_walker)


def _asks_to_look(meeting: Meeting, line: Path) -> bool:
    """True for a turn with a way that has priority and is not held by a light."""
    inside = (line.s >= meeting.wait_s) & (line.s <= meeting.last_s)
    if float(line.speed[inside].min()) > _A_TURN_MPS:
        return False
    return any(way.goes_first and not any(map(_is_red, way.lights)) for way in meeting.ways)


class OtherOnWay(NamedTuple):
    """A vehicle on another way."""

    actor_id: int
    s: float
    speed: float
    half_length: float
    half_width: float


def on_way(way: MeetingWay, others: NearbyBodies) -> list[OtherOnWay]:
    """Return those of the others that drive along a way."""
    if len(others) == 0:
        return []
    dx, dy = others.x[:, None] - way.x, others.y[:, None] - way.y
    nearest = np.argmin(dx * dx + dy * dy, axis=1)
    rows = np.arange(len(others))
    cos, sin = np.cos(way.yaw[nearest]), np.sin(way.yaw[nearest])
    along = dx[rows, nearest] * cos + dy[rows, nearest] * sin
    aside = dy[rows, nearest] * cos - dx[rows, nearest] * sin
    speed = others.vx * cos + others.vy * sin
    on_it = (np.abs(aside) < _ON_WAY_M) & (speed > _ALONG_COS * np.hypot(others.vx, others.vy))
    on_it &= np.abs(along) < others.half_length + 1.0
    return [
        OtherOnWay(
            others.actor_id[i],
            float(way.s[nearest[i]] + along[i]),
            float(speed[i]),
            float(others.half_length[i]),
            float(others.half_width[i]),
        )
        for i in np.flatnonzero(on_it).tolist()
    ]


def of_one_pace(seen: Sequence[tuple[MeetingWay, OtherOnWay]]) -> list[tuple[MeetingWay, OtherOnWay]]:
    """Return them with the median speed of their stream, where their own differs from it by no more than noise."""
    paces = {}
    for way in {id(way): way for way, _ in seen}.values():
        speeds = [one.speed for its, one in seen if its is way]
        paces[id(way)] = float(np.median(speeds)) if len(speeds) >= STREAM else math.nan
    usual = [abs(one.speed - paces[id(way)]) < NOISE_MPS for way, one in seen]
    return [
        (way, one._replace(speed=paces[id(way)]) if noise else one)
        for (way, one), noise in zip(seen, usual, strict=True)
    ]


def pace_of_flow(coming: Sequence[tuple[MeetingWay, OtherOnWay]]) -> float:
    """Return the speed of priority traffic where the route joins it (m/s); unlimited without any."""
    return max((one.speed for way, one in coming if way.joins and way.goes_first), default=math.inf)


def _comes(way: MeetingWay, other: OtherOnWay) -> bool:
    """True if it has the right of way, or will not stop without it."""
    front = other.s + other.half_length
    to_line = way.inside_s - front
    if other.speed**2 - way.bend_mps**2 > 2.0 * _SLOWING_MPS2 * max(to_line, 1.0) and to_line > 0.0:
        return False  # too fast to turn there: it goes another way
    stops = to_line > 0.0 and other.speed**2 < 2.0 * _STOPPING_MPS2 * to_line
    if way.goes_first and not (stops and any(_is_red(light) for light in way.lights)):
        return True
    return not stops and (way.straight or to_line < -2.0)


def _is_red(light: carla.TrafficLight) -> bool:
    return bool(light.state == carla.TrafficLightState.Red)


class Drive:
    """The predicted positions of the ego if it goes now."""

    def __init__(
        self,
        line: Path,
        s: Array,
        model: VehicleModel,
        slips: bool = False,
        joined_s: float = JOINED_S,
        followers: bool = True,
    ) -> None:
        """`slips`: in a bend the body points less far round than its centre moves, which matters on a tight one.
        `joined_s`: see `JOINED_S`. `followers`: who follows on the common way counts as a leader, too, which it does if
        the ego has joined with little room.
        """
        self._joined_s, self._followers = joined_s, followers
        self._s = s
        self._t = STEP_S * np.arange(len(s))
        self._x, self._y, self._yaw = line.at(s)
        if slips:
            sine = model.rear_axle * np.interp(s, line.s, line.curvature)
            self._yaw = self._yaw - np.arcsin(np.clip(sine, -0.8, 0.8))
        self._model = model

    def judge(self, coming: Sequence[tuple[MeetingWay, OtherOnWay]], margin: Margin) -> Met:
        """Return whom of the traffic it would meet, or come too near to."""
        met, passing, leaders = list[tuple[MeetingWay, int]](), set[int](), list[LeadVehicle]()
        pass_soon = True
        for way, other in coming:
            surely, likely = self._comes_behind(way, other)
            if not surely and self._meets(way, other, margin):
                met.append((way, other.actor_id))
                pass_soon &= self._comes_behind(way, other, LETS_PASS_S)[1]
            elif not way.joins:
                passing.add(other.actor_id)
            elif likely:
                leader = self._leader(way, other)
                if self._followers or leader.gap_m > -2.0 * self._model.half_length:
                    leaders.append(leader)
        clear = passing.difference(actor_id for _, actor_id in met)
        return Met(tuple(way for way, _ in met), frozenset(clear), min(leaders, default=None), pass_soon)

    def _arrives_s(self, way: MeetingWay) -> float:
        """Return when its front reaches the place where the ways meet (s)."""
        return float(np.interp(way.route_meets_s - self._model.half_length, self._s, self._t))

    def _comes_behind(self, way: MeetingWay, other: OtherOnWay, later_s: float = 0.0) -> tuple[bool, bool]:
        """Return whether the other will have passed, or be ahead on the common way, when the ego arrives:
        (surely, likely). `later_s`: the ego arrives so much later (s).
        """
        left = (way.meets_s + 1.0 if way.joins else way.parts_s) - (other.s - other.half_length)
        arrives_s = self._arrives_s(way) + later_s
        return other.speed * _EARLY * arrives_s > left, other.speed * arrives_s > left

    def _leader(self, way: MeetingWay, other: OtherOnWay) -> LeadVehicle:
        """Return the other as if it were as far along the route as it is along its way."""
        front = float(self._s[0]) + self._model.half_length
        return LeadVehicle(other.s - other.half_length - way.meets_s - (front - way.route_meets_s), other.speed)

    def _meets(self, way: MeetingWay, other: OtherOnWay, margin: Margin) -> bool:
        """True if it would come nearer to the other than the margin while their ways meet."""
        half = self._model.half_length
        t_in = self._arrives_s(way)
        until = way.route_parts_s + half
        when = (self._s > way.route_meets_s - half) & (
            (self._t < t_in + self._joined_s) if way.joins else (self._s < until)
        )
        if not when.any():
            return False
        before = margin.before_m + margin.before_s * other.speed
        behind = margin.behind_m + margin.behind_s * other.speed
        t = self._t[when]
        to_bend_s = max(way.inside_s - other.s, 0.0) / max(other.speed, _LEAST_MPS)
        gone = other.speed * np.minimum(t, to_bend_s) + min(other.speed, way.bend_mps) * np.maximum(t - to_bend_s, 0.0)
        s = other.s + (before - behind) / 2.0 + gone
        x, y, yaw = np.interp(s, way.s, way.x), np.interp(s, way.s, way.y), np.interp(s, way.s, way.yaw)
        over = np.maximum(s - way.s[-1], 0.0)
        x, y = x + over * np.cos(yaw), y + over * np.sin(yaw)
        gap = separation(
            (self._x[when], self._y[when], self._yaw[when]),
            (half, self._model.half_width + _MARGIN_M),
            (x, y, yaw),
            (other.half_length + (before + behind) / 2.0, other.half_width),
        )
        return bool((gap <= 0.0).any())


def foretold(
    line: Path,
    s: float,
    speed: float,
    top_mps: float,
    profile: Profile,
    bends: float,
    lag_s: float,
    pull: Callable[[float], float] | None = None,
    horizon_s: float = HORIZON_S,
) -> Array:
    """Return the arc lengths of the ego's centre over the horizon if only the line's bounds hold it back (m).

    `pull` gives the highest acceleration of the vehicle at a speed (m/s²), where the profile's is not reached.
    """
    spacing = float(line.s[1]) if len(line.s) > 1 else 1.0
    bounds, last = line.speed, len(line.speed) - 1
    found, lag = [], lag_s if speed < 1.0 else 0.0
    for k in range(round(horizon_s / STEP_S)):
        found.append(s)
        bound = bends * float(bounds[min(int((s + 0.4 * speed) / spacing), last)])
        if k * STEP_S >= lag:
            wanted = toward_speed(speed, min(bound, top_mps), profile)
            speed = max(speed + STEP_S * (wanted if pull is None else min(wanted, pull(speed))), 0.0)
        s += STEP_S * speed
    return np.array(found)
