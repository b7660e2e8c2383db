"""The search for plans, and the glance that ranks them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from tests.worlds import LANE_M, World, bent_road, straight_road, thing

from lab.language.plan_search.beam_search import Search, SearchSettings, kinds, varied
from lab.language.plan_search.ego_trajectory import EgoTrajectory, begin
from lab.language.plan_search.quick_value import MOST_PROGRESS_M, QuickValue
from stucksolver.guard import Guard
from stucksolver.scene import LineKind
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.objects import ObjectKind
from stucksolver.solver.state_machine.execution import Execution

TWO_LANES = straight_road(left=LineKind.BROKEN, oncoming=None)
QUICK = SearchSettings(depth=2, beam=2, steps=2, later_steps=2)


def ahead(meters: float, across: float = 0.0, speed_mps: float = 6.0) -> EgoTrajectory:
    """A trail from (50, 0) that shifts sideways at once and then drives on."""
    t = np.linspace(0.0, meters / speed_mps, 30)
    x = 50.0 + speed_mps * t
    y = np.clip(x - 50.0, 0.0, 8.0) / 8.0 * across
    return EgoTrajectory(t, np.column_stack([x, y, np.zeros(30)]), speed_mps)


def blocked(*more, **world):
    return World(TWO_LANES, [thing("lead", 62.0, 0.0, kind=ObjectKind.CAR), *more], **world)


def test_quick_value_passing_exceeds_waiting_and_waiting_exceeds_contact() -> None:
    """Passing is worth more than remaining stopped, and remaining stopped more than a contact."""
    glance = QuickValue(blocked().surroundings())
    past, stays, through = ahead(40.0, LANE_M), begin(blocked().surroundings()), ahead(40.0)
    assert glance.value(past) == pytest.approx(MOST_PROGRESS_M)
    assert 0.0 < glance.value(stays) < 10.0
    assert glance.value(through) < -100.0


def test_quick_value_departing_lead_causes_less_contact() -> None:
    """A lead vehicle that drives away causes no contact in one of the two predicted futures."""
    leaving = QuickValue(blocked().surroundings()).value(ahead(10.0))
    moving = World(TWO_LANES, [thing("lead", 62.0, 0.0, kind=ObjectKind.CAR, speed=8.0)])
    assert QuickValue(moving.surroundings()).value(ahead(10.0)) > leaving + 50.0


def test_who_stood_beside_already_is_no_near_miss() -> None:
    beside = thing("parked", 50.0, -2.1, kind=ObjectKind.CAR)
    assert QuickValue(World(TWO_LANES, [beside]).surroundings()).value(ahead(40.0)) == pytest.approx(MOST_PROGRESS_M)


def test_an_empty_road_and_a_bend_have_values() -> None:
    for road in (TWO_LANES, bent_road(60.0)):
        seen = World(road, x=0.0).surroundings()
        assert math.isfinite(QuickValue(seen).value(begin(seen)))


@pytest.mark.integration
@pytest.mark.parametrize("speed_mps", [0.0, 4.0])
def test_every_plan_found_is_accepted_by_the_guard(speed_mps: float) -> None:
    world = blocked(thing("other", 40.0, LANE_M, kind=ObjectKind.CAR, speed=speed_mps))
    guard, seen = Guard(), world.surroundings()
    found = Search(guard, world.scene(seen), seen, QuickValue(seen).value, QUICK).run()
    assert found
    assert [item.value for item in found] == sorted((item.value for item in found), reverse=True)
    for item in found:
        verdict = Execution(item.plan, guard, guided=False).start(FrenetScene(seen), seen.time_s)
        assert verdict.accepted, (kinds(item.plan.behaviors), verdict)


@pytest.mark.integration
def test_search_is_deterministic_and_finds_pass_among_first_plans() -> None:
    """A second search finds the same plans, and a pass is among the first."""
    world = blocked()
    seen = world.surroundings()
    runs = [Search(Guard(), world.scene(seen), seen, QuickValue(seen).value, QUICK).run() for _ in range(2)]
    assert [run.plan for run in runs[0]] == [run.plan for run in runs[1]]
    first = varied(runs[0], lambda run: (kinds(run.plan.behaviors), run.value), 3)
    assert max(item.value for item in first) == pytest.approx(MOST_PROGRESS_M)
    assert any("change_lane" in kinds(item.plan.behaviors) for item in first)


@pytest.mark.release
@pytest.mark.integration
def test_campaign_interrupted_resumes_where_it_ended(tmp_path: Path) -> None:
    """A campaign labels complete standstills, and a resumed one drives only what is missing."""
    pytest.importorskip("carla")
    from lab.language.plan_search.campaign import PlanSearchSpec, collect
    from lab.language.plan_search.counterfactual_run import DriveSpec
    from stucksolver_eval.suites import load_routes, suite

    said: list[str] = []
    spec = PlanSearchSpec(
        suite="immobilized",
        suite_digest=suite("immobilized").digest,
        routes=load_routes("immobilized", ("3023",)),
        seed=5,
        out=tmp_path,
        best=1,
        jobs=2,
        drives=DriveSpec(limit_s=25.0),
        search=SearchSettings(depth=1, beam=1, steps=2, looked=2),
    )
    labels = collect(spec, said.append).labels
    sources = [label.source for label in labels]
    assert sorted(sources) == ["rules", "teacher", "wait"]
    assert all(label.counts for label in labels), [label.error for label in labels]
    # The last label is lost, as by a kill: only this one is driven again, with the same outcome.
    file = tmp_path / "labels.jsonl"
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    file.write_text("".join(lines[:-1]), encoding="utf-8")
    said.clear()
    again = collect(spec, said.append).labels
    assert [line for line in said if "drives so far" in line] == [said[0]]
    assert again[-1].grade == labels[-1].grade
