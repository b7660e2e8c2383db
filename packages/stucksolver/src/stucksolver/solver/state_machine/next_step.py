"""Decides whether a plan between two of its steps still waits for traffic."""

from __future__ import annotations

from dataclasses import replace

from stucksolver.guard import RejectCode, Verdict
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.objects import STATIC_KINDS
from stucksolver.solver.state_machine.execution_phases import AwaitingNext
from stucksolver.solver.state_machine.gap_wait import SENSED_WAIT_S, sight_may_improve
from stucksolver.solver.state_machine.history import moving, passes

STILL_S = 1.5
"""A plan between two steps waits this long for an object that stays (s). Ours: perception may err for a moment."""
PARKED_S = 10.0
"""A vehicle that has been stationary this long counts as one that stays (s), as `WaitLimits.unknown_vehicle_s`."""


def awaiting_next(
    before: AwaitingNext | None, verdict: Verdict, view: FrenetScene, now_s: float, wait_s: float, *, returns: bool
) -> tuple[AwaitingNext, bool]:
    """Return the wait after one more tick, and True if the step may still become possible by waiting.

    Args:
        before: The wait so far; None at its first tick.
        verdict: The rejection of the next step.
        view: The surroundings in road coordinates.
        now_s: The solver's own time (s).
        wait_s: Longest wait for traffic (s).
        returns: True for the return from the roadside, where the vehicle stands safely.
    """
    waiting = before or AwaitingNext(now_s + wait_s, now_s)
    since_s = now_s if waiting.still_s is None else waiting.still_s
    still_s = since_s if _names_stationary(verdict, view) else None
    sensed = view.ego.position_sd_m is not None
    stays = still_s is not None and now_s - still_s >= (SENSED_WAIT_S if sensed else STILL_S)
    passing = returns or (passes(verdict, moving(view), sensed=sensed) and not stays)
    waiting = replace(waiting, still_s=still_s, traffic_s=now_s if passing else waiting.traffic_s)
    return waiting, passing or sight_may_improve(verdict, view.ego, now_s - waiting.traffic_s)


def _names_stationary(verdict: Verdict, view: FrenetScene) -> bool:
    """True if a verdict rejects a step for the traffic in a lane, but the object is not traffic: it stays there."""
    for reason in verdict.rejects:
        index = None if reason.object_id is None else view.index_of(reason.object_id)
        if index is None or reason.code not in (RejectCode.ONCOMING_GAP, RejectCode.LANE_ENTRY):
            continue
        obj = view.objects[index]
        if not view.moving[index] and (obj.kind in STATIC_KINDS or (obj.stationary_s or 0.0) >= PARKED_S):
            return True
    return False
