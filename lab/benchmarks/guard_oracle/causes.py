"""Contacts that are excused, and the sentence of `docs/SAFETY.md` for each.

An excuse holds if facts of the recorded drive show it. Most of them require a counterfactual as well: no stop avoids
the contact that begins when the other was first in sight, or at any time after it. A contact that no excuse covers
counts against the guard.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lab.benchmarks.guard_oracle.bodies import Body
from lab.benchmarks.guard_oracle.case import Case
from lab.benchmarks.guard_oracle.counterfactual import following_avoids
from lab.benchmarks.guard_oracle.others import ANSWERS_AFTER_S, STOOD_LONG_S, AlongLane, StepsOff, Straight
from lab.benchmarks.guard_oracle.recording import other_of
from lab.benchmarks.guard_oracle.vehicle import LENGTH_M, WIDTH_M
from lab.benchmarks.guard_oracle.world import AT_REST_MPS, DT
from stucksolver.plan import Execute
from stucksolver.scene import ZoneKind

OTHERS_BRAKE_MPS2 = 3.5
"""Deceleration of other vehicles (m/s²), as in assumption A2."""
STEPS_REACTION_S = 0.5
"""Reaction time of a pedestrian (s), as short as the ego's in assumption A5."""
TOLERANCE_M = 0.15
"""Space that a tracking error may use up (m), as in assumption A3."""
FOLLOWS_M = 2.0
"""Distance of a vehicle that follows a lead vehicle off rails (m).

It is 1.5 m, and the error of the follower model.
"""
Holds = Callable[[Case], bool]
EXCUSES: dict[str, Holds] = {}


def excuse(says: str) -> Callable[[Holds], Holds]:
    """Register an excuse under the sentence that the page shows."""

    def register(holds: Holds) -> Holds:
        EXCUSES[says] = holds
        return holds

    return register


def excused_by(case: Case) -> str | None:
    """Return the sentence of the first excuse that holds, or None."""
    return next((says for says, holds in EXCUSES.items() if holds(case)), None)


@excuse("void: the other came through somebody else, since the oracle's others do not see each other")
def through(case: Case) -> bool:
    """Represents no sentence: such a drive is physically impossible.

    The other has overlapped another actor before, and no stop avoids the contact since it is in sight. If a stop does,
    the guard had all it needed, whatever the other overlapped.
    """
    return case.contact.name in case.end.through and case.no_stop_avoids(case.first_visible)


@excuse("H4: somebody hidden stepped out within a stopping distance")
def steps_out(case: Case) -> bool:
    """Represents the residual risk of H4: "someone hidden who steps out within a stopping distance".

    The pedestrian was hidden when the plan began, and no stop avoids the contact since the pedestrian is in sight.
    """
    hidden = case.contact.kind == "pedestrian" and case.first_visible != 0
    return hidden and case.no_stop_avoids(case.first_visible)


@excuse("not covered: on a crossing road, and not in sight before it was too late to stop")
def hidden_crosser(case: Case) -> bool:
    """Represents "not covered: on a crossing road, traffic that is not in sight yet" (section 7).

    The other was not in sight when the plan began, and no stop avoids the contact since it is.
    """
    crosses = case.role == "crosses" and case.first_visible != 0
    return crosses and case.no_stop_avoids(case.first_visible)


@excuse("not covered: gave way to somebody on a crossing road who came into sight too late, in the path of another")
def caught_between(case: Case) -> bool:
    """Represents "not covered: on a crossing road, traffic that is not in sight yet" (section 7), for a second vehicle.

    The ego yields to such traffic and is hit by another crossing vehicle. A crossing vehicle came into sight after the
    start, and no stop avoids the contact since then, neither with it nor with the other. Driven again without all road
    users that came into sight that late, the plan ends without a contact that counts.
    """
    if case.role != "crosses":
        return False
    roles = {other.name: other.role for other in case.end.others}
    late = {name: tick for name, tick in case.came_into_sight.items() if roles[name] == "crosses"}
    too_late = frozenset(name for name, tick in late.items() if case.no_stop_avoids(tick))
    return bool(too_late) and case.again(too_late)


@excuse("A6: traffic ahead in our lane, which the stack follows")
def leads(case: Case) -> bool:
    """Represents A6: "traffic ahead in our lane is followed by the stack".

    The stack of this drive did not follow, and the front of the ego touched the other's rear. The path in force runs
    into the other's lane and stays there: a plan that swings around the other does not follow. Driven again with a
    stack that keeps its distance with comfortable braking, there is no contact.
    """
    contact, other = case.contact, case.other
    if case.recording.start.ego.manner.follows or not isinstance(other, AlongLane) or other.way < 0:
        return False
    if contact.part == "rear" or contact.their_part != "rear" or swings_round(case):
        return False
    return following_avoids(case.recording, contact.name)


def swings_round(case: Case) -> bool:
    """True if the path in force leads out of the other's strip again, or never into it."""
    order = next((o for o in reversed(case.recording.orders) if isinstance(o, Execute) and o.path), None)
    if order is None:
        return True
    d, half = case.frames[-1].other_d, (WIDTH_M + case.frames[-1].other.width) / 2
    s, within = case.recording.start.ego_s, []
    for point in order.path:
        s, offset = case.end.road.find(point.x_m, point.y_m, s)
        within.append(abs(offset - d) < half)
    return True not in within or not all(within[within.index(True) :])


@excuse("A3: came from behind in our own lane, and left less room beside us than a tracking error may take")
def filters(case: Case) -> bool:
    """Represents A3: traffic from behind keeps "at least the 0.15 m that a tracking error may use up".

    The other would have had less space if the ego had gone straight on since the last tick at which the other could
    stop behind it. No stop avoids the contact since the other is abreast of the ego.
    """
    if case.role != "filters past us":
        return False
    behind = [k for k, frame in enumerate(case.frames) if frame.stops_behind]
    before, now = case.frames[behind[-1] if behind else 0], case.frames[-1]
    room = abs(now.other_d - before.ego_d) - (WIDTH_M + now.other.width) / 2
    abreast = next((k for k, frame in enumerate(case.frames) if frame.abreast and frame.visible), None)
    return room < TOLERANCE_M and case.no_stop_avoids(abreast)


@excuse("not covered: was stationary, set off as we passed, and did not brake for us")
def sets_off(case: Case) -> bool:
    """Represents "not covered: a stationary vehicle that sets off just as we are alongside and does not brake for us".

    The other, a vehicle, had been stationary for a driver's reaction time before it set off. No stop of the ego avoids
    the contact that begins since the other visibly moves. The contact was not the ego's front with the other's rear.
    """
    other, contact = case.other, case.contact
    if not isinstance(other, AlongLane | Straight) or contact.kind == "pedestrian" or other.sets_off_at > contact.t:
        return False
    began, frames = min(round(other.sets_off_at / DT), case.last), case.frames
    moved = max((k for k in range(began) if frames[k].other_speed > AT_REST_MPS), default=-math.inf)
    stood_s = (began - max(moved, 0)) * DT + (other_of(case.recording.start, other.name).stood if moved < 0 else 0.0)
    if frames[began].other_speed > AT_REST_MPS or stood_s < ANSWERS_AFTER_S or contact.their_part == "rear":
        return False
    moves = range(began, case.last)
    visible_tick = next((k for k in moves if frames[k].visible and frames[k].other_speed > AT_REST_MPS), None)
    # The outcome of going on depends on the other's acceleration, which is unknown at that time.
    return case.no_stop_avoids(visible_tick, or_going_on=False)


@excuse("H14: the solver was silent past the commit point, and the oracle's vehicle has no braking of its own")
def silent(case: Case) -> bool:
    """Represents H14: "past the commit point the rest is driven with only the stack's own braking".

    The solver was silent, its last directive had expired, and the vehicle went on to finish its path, which it does
    past the commit point only. A stop avoids the contact that begins since then with the other in sight: that is the
    purpose of the stack's own braking. Driven again with a solver that is never silent, the plan ends without a contact
    that counts.
    """
    frames, since = case.frames, case.recording.silent_from
    last = case.recording.orders[-1]
    if not (isinstance(last, Execute) and last.path) or case.contact.t <= since + last.expires_ticks * DT:
        return False
    visible_tick = next((k for k, frame in enumerate(frames[:-1]) if frame.t >= since and frame.visible), None)
    return visible_tick is not None and not case.no_stop_avoids(visible_tick) and case.again(frozenset())


@excuse("A3: ran into the vehicle that stood, and could have stopped before it")
def runs_into_us(case: Case) -> bool:
    """Represents A3 for a stopped ego.

    The sentence is: traffic from behind in our lane, "or [that] approaches a vehicle that has long been stopped, keeps
    its own distance".

    The ego was stopped at the contact. From then on the other could have stopped at 3.5 m/s² after its reaction time.
    The other is a pedestrian, a vehicle behind the ego in its lane, or a vehicle on a crossing road for which the ego
    has long been stopped. For the last, no stop avoids the contact since it is in sight: stopping in its path in full
    view is no excuse.
    """
    since, walks = case.stands_since, case.contact.kind == "pedestrian"
    if since is None or not (walks or case.role in ("follows us", "crosses")):
        return False
    reaction_s = STEPS_REACTION_S if walks else ANSWERS_AFTER_S
    if case.needs_mps2(since, reaction_s) > OTHERS_BRAKE_MPS2:
        return False
    if walks or case.role == "follows us":
        return True
    return (case.last - since) * DT >= STOOD_LONG_S and case.no_stop_avoids(case.first_visible)


@excuse("not covered: on the rails from the start, behind somebody who leaves them no quicker")
def trapped(case: Case) -> bool:
    """Represents "not covered: a train, if a plan begins on its rails behind a vehicle that crawls off them no faster".

    The drive began on rails behind a lead vehicle. Up to the contact the lead vehicle has not moved the length of the
    ego beyond the rails. No stop avoids the contact since the train is in sight.
    """
    if case.role != "train" or not case.recording.start.led_from_rails:
        return False
    zones = case.end.road.zones
    beyond = max((end for kind, _, end in zones if kind is ZoneKind.LEVEL_CROSSING), default=math.inf)
    rears = [o.s - o.body.length / 2 for o in case.end.others if isinstance(o, AlongLane) and o.role == "leads"]
    crawls = bool(rears) and min(rears) < beyond + LENGTH_M + FOLLOWS_M
    return crawls and case.no_stop_avoids(case.first_visible)


@excuse("R5: stepped off and walked into our front, which stood")
def into_our_front(case: Case) -> bool:
    """Represents R5: "our front never hits someone who steps off the curb".

    The ego was stopped at the contact and one tick before it, and the pedestrian, who steps off, walked.
    """
    if not isinstance(case.other, StepsOff) or not case.other.walks:
        return False
    return case.contact.part == "front" and all(abs(f.ego_speed) < AT_REST_MPS for f in case.frames[-2:])


@excuse("R5: stepped off into our side, after our front had passed")
def into_our_side(case: Case) -> bool:
    """Represents R5: "our front never hits someone who steps off the curb". R5 promises nothing about the side.

    One tick before the contact the pedestrian, who steps off, was wholly behind the leading face of the ego. More than
    half of the closing speed to its side was the pedestrian's own.
    """
    if not isinstance(case.other, StepsOff) or not case.other.walks or case.last < 1:
        return False
    before, now = case.frames[-2], case.frames[-1]
    forward = 1.0 if now.ego_speed >= 0.0 else -1.0
    foremost = max(forward * x for x, _ in seen_from(before.ego, before.other.corners()))
    ((_, was),), ((_, came),) = (seen_from(f.ego, ((f.other.x, f.other.y),)) for f in (before, now))
    ((_, walked),) = seen_from(before.ego, ((now.other.x, now.other.y),))
    passed = foremost < before.ego.length / 2
    return passed and (walked - was) * (came - was) > 0.0 and abs(walked - was) >= abs(came - was) / 2


def seen_from(ego: Body, points: tuple[tuple[float, float], ...]) -> list[tuple[float, float]]:
    """Return points in the plane as (ahead, to the left) of a body (m)."""
    c, n = math.cos(ego.yaw), math.sin(ego.yaw)
    away = np.array(points) - (ego.x, ego.y)
    return [(float(x * c + y * n), float(y * c - x * n)) for x, y in away]
