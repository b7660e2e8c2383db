"""Converts a campaign to samples, so that the student learns the value of a plan from exact drives.

Plans that were not driven are judged as at any other sample: by the guard, and with a quick value. A quick value does
not take into account that the driver stays in the lane into which a plan has led it. Therefore no plan counts for more
than the best driven one of its kind.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from lab.language.plan_search.decision_samples import SUFFIX, DecisionSample, JudgedPlan, judge, write_moments
from lab.language.plan_search.grade import Grade
from lab.language.plan_search.labels import Label, by_standstill
from lab.language.plan_search.standstill import Standstill
from stucksolver.guard import Guard
from stucksolver.plan import RecoveryPlan
from stucksolver_eval.metrics.recovery import WITHIN_S
from stucksolver_language.student.scene_codec import write_scene

HARM_M = -30.0
"""Value of a drive with a collision or an infraction (m): less than any other. Ours."""
FILE = f"moments/campaign{SUFFIX}"


def write_lessons(folder: Path, standstills: Path, labels: Sequence[Label], guard: Guard) -> None:
    """Write the samples of a campaign into its folder.

    Args:
        folder: The campaign's folder.
        standstills: Folder of its standstills.
        labels: Its exact drives.
        guard: The guard that judges the other plans.

    Raises:
        OutputError: The file cannot be written.
    """
    write_moments(folder / FILE, lessons(standstills, labels, guard))


def lessons(standstills: Path, labels: Sequence[Label], guard: Guard) -> Iterator[DecisionSample]:
    """Yield a sample for each standstill.

    It has the plans that were driven there with their values, and the other candidates with the guard's verdict.
    """
    for name, group in by_standstill(labels).items():
        path = standstills / f"{name}.json"
        still = Standstill.model_validate_json(path.read_text(encoding="utf-8"))
        driven = {
            label.plan: JudgedPlan(plan=label.plan, value_m=worth_m(label.grade))
            for label in group
            if label.counts and label.plan is not None and label.grade is not None
        }
        judged = [capped(item, driven.values()) for item in judge(still.scene, still.surroundings, guard)]
        yield DecisionSample(
            suite=still.suite,
            route_id=still.route_id,
            seed=still.seed,
            scenario=still.scenario,
            town=still.town,
            standstill=0,
            at_s=still.at_s,
            scene=write_scene(still.scene),
            # A label does not contain the duration of a drive without a recovery. Only waits that ended would be known,
            # and the student would learn that waits end.
            gone_after_s=None,
            watched_s=0.0,
            plans=(*(item for item in judged if item.plan not in driven), *driven.values()),
        )


def capped(plan: JudgedPlan, driven: Iterable[JudgedPlan]) -> JudgedPlan:
    """Return a plan that was not driven, with at most the value of the best driven one of its kind."""
    kind = _kind(plan.plan)
    alike = [other.value_m for other in driven if other.value_m is not None and _kind(other.plan) == kind]
    if plan.value_m is None or not alike:
        return plan
    return JudgedPlan(plan=plan.plan, value_m=min(plan.value_m, max(alike)))


def _kind(plan: RecoveryPlan) -> tuple[str, ...]:
    return tuple(behavior.name for behavior in plan.behaviors if not behavior.stands_still)


def worth_m(grade: Grade) -> float:
    """Return the value of a drive (m), on the scale of a plan's quick value: a meter for each second gained.

    A route that was not driven to its end has the completed share of that.
    """
    if grade.collisions + grade.infractions > 0:
        return HARM_M
    if grade.recovered_after_s is None:
        return 0.0
    return round(max(WITHIN_S - grade.recovered_after_s, 0.0) * grade.completion / 100.0, 2)
