"""Value of a plan in meters of progress, from the guard's assessment alone: a closed-form look ahead."""

from __future__ import annotations

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.assessment import PlanAssessment, Shortfall
from stucksolver.reasoners.duties.analysis import NEAR_M
from stucksolver.scene import PlanFailure, RejectCode, Scene
from stucksolver.scene.own_path import IN_LANE_M

HORIZON_S = 40.0
"""Time for which progress counts (s). A pass takes about 15 s. Ours."""
CRUISE_MPS = 6.0
"""Assumed speed on the free road after the plan, with the start from a stop (m/s). Ours."""
MOST_PROGRESS_M = 60.0
"""Greatest progress that counts (m). Ours."""
WORTH_M = 10.0
"""A plan is worth driving if it leads this much further than the free road ahead of the ego now (m). Ours."""
LEAST_PROGRESS_M = 5.0
"""A plan that ends less than this ahead of where it began is not worth driving (m). Ours."""
PROVEN_M, PROVEN_WEIGHT = 15.0, 1.5
"""Progress under the guard's proof counts more than the road after it, up to this distance (m). What has stopped the
ego may stop it again there: a recovery is 15 m of progress. Ours.
"""
SECOND_COST_M = 0.5
"""Cost of a second (m): a quicker plan is in the way of others for less time. Ours."""
BACK_COST = 0.5
"""Cost of a meter in reverse (m). Ours."""
ONCOMING_COST = 0.2
"""Cost of a meter in an oncoming lane (m). Ours: a flat bag is rather driven over than passed there."""
OFF_LANE_COST = 3.0
"""Cost of a meter beside the route's lane at the end (m). Ours."""
STEP_COST_M = 1.0
"""Cost of each behavior: a simple plan is easier to follow for everyone (m). Ours."""
SHIFT_COST_M = 2.0
"""Cost of each behavior that leaves the line of the lane: without need, it looks odd to others (m). Ours."""
TRAFFIC_COST_M = 12.0
"""Cost of waiting for traffic (m). Ours: it takes longer than a small detour."""
APPROVAL_COST_M = 15.0
"""Cost of asking a person (m). Ours, for the same reason."""
FAILED_COST_M = 25.0
"""Cost of a plan that failed a short time ago for a reason that cannot be seen before it starts (m). Ours."""
RATES = {"m": 30.0, "s": 0.5, "m/s": 4.0}
"""Distance of a refused plan from being accepted, for each unit that is missing (m). Ours."""
SIGHT_RATE = 0.2
"""The same for a meter of sight: it is much less than a meter of room (m). Ours."""
UNKNOWN_COST_M = 60.0
"""The same if the missing amount is unknown (m). Ours."""


def value_m(plan: RecoveryPlan, assessment: PlanAssessment) -> float:
    """Return the progress that a plan promises less its costs (m).

    Args:
        plan: The plan.
        assessment: Assessment of all of its steps. What is refused only for traffic or for lack of an approval counts
            with its steps up to there.
    """
    rest_s = max(HORIZON_S - assessment.duration_s, 0.0)
    onward = min(assessment.free_m, CRUISE_MPS * rest_s)
    gain = PROVEN_WEIGHT * min(assessment.progress_m, PROVEN_M) + min(onward, MOST_PROGRESS_M - PROVEN_M)
    off_m = max(abs(assessment.offset_m) - IN_LANE_M, 0.0)
    cost = BACK_COST * assessment.back_m + ONCOMING_COST * assessment.oncoming_m + OFF_LANE_COST * off_m
    cost += STEP_COST_M * len(plan.behaviors) + SECOND_COST_M * assessment.duration_s
    cost += SHIFT_COST_M * sum(behavior.shifts_laterally for behavior in plan.behaviors)
    if any(item.passing for item in assessment.shortfalls):
        cost += TRAFFIC_COST_M
    if any(item.approval for item in assessment.shortfalls):
        cost += APPROVAL_COST_M
    return gain - cost


def is_worth_driving(assessment: PlanAssessment, free_now_m: float) -> bool:
    """True if a plan leads further than the free road ahead of the ego now. `free_now_m`: that distance (m)."""
    if assessment.progress_m < LEAST_PROGRESS_M:
        return False
    gain = min(assessment.progress_m + assessment.free_m, MOST_PROGRESS_M)
    return gain >= min(free_now_m + WORTH_M, MOST_PROGRESS_M) or (
        # Beyond `NEAR_M` nothing in the path has stopped the ego: a free road is worth driving on.
        free_now_m > NEAR_M and assessment.progress_m >= WORTH_M
    )


def shortfall_m(assessment: PlanAssessment) -> float:
    """Return how far a refused plan is from being accepted, as a length (m)."""
    return sum(_lacks_m(item) for item in assessment.shortfalls if not (item.passing or item.approval))


def _lacks_m(item: Shortfall) -> float:
    if item.missing is None:
        return UNKNOWN_COST_M
    sight = item.code in (RejectCode.ONCOMING_SIGHT, RejectCode.PATH_NOT_VISIBLE)
    return item.missing * (SIGHT_RATE if sight else RATES.get(item.unit or "", 0.0))


HOPELESS = frozenset(
    {
        PlanFailure.NO_LANE,
        PlanFailure.NOT_OUR_LANE,
        PlanFailure.NOT_SEEN,
        PlanFailure.NOT_IN_THE_WAY,
        PlanFailure.NOT_LEADING,
        PlanFailure.EMPTY,
    }
)
"""Reasons for the lack of a path that no other parameter and no other start removes."""


def is_hopeless(assessment: PlanAssessment) -> bool:
    """True if no preparation makes a refused plan acceptable: there is no such lane or object."""
    return any(item.failure in HOPELESS for item in assessment.shortfalls)


def has_failed(scene: Scene, plan: RecoveryPlan, within_s: float) -> bool:
    """True if a plan with these behaviors and parameters was aborted within the last seconds."""
    recent = [attempt.plan for attempt in scene.attempts if scene.time_s - attempt.time_s < within_s]
    return bool(recent) and tuple(behavior.model_dump_json() for behavior in plan.behaviors) in recent
