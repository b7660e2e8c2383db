"""A small, fixed part of the oracle's campaign, and that the oracle itself sees what it should.

The whole is `python -m lab.benchmarks.guard_oracle`; what it found is in `results/guard_oracle.md`.
"""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace

import pytest

from lab.benchmarks.guard_oracle.__main__ import campaign
from lab.benchmarks.guard_oracle.bodies import Body, distance, part_touched
from lab.benchmarks.guard_oracle.campaign import scene_rows, setting_of
from lab.benchmarks.guard_oracle.road import Road, lanes_of
from lab.benchmarks.guard_oracle.scene import (
    BLOCK,
    CLASSES,
    LATER,
    Setting,
    all_classes,
    at_the_kerb,
    class_of,
    driving,
    number_of,
    scene_class,
)
from lab.benchmarks.guard_oracle.vehicle import LENGTH_M, WHEELBASE_M, Ego, Manner
from lab.benchmarks.guard_oracle.world import World
from stucksolver.guard import guard as guard_module
from stucksolver.plan import Execute
from stucksolver.plan.behaviors import Check, KeepLane, Wait
from stucksolver.plan.directive import PathPoint

SEED, PLANS_OF_A_SCENE = 1, (0, 1, 2)
NAMES = list(CLASSES)
STREET = Road("street", [(330.0, 0.0)], lanes_of("multi"))


@pytest.mark.integration
@pytest.mark.parametrize("name", all_classes())
def test_campaign_accepted_plans_have_no_unexcused_contact(name):
    """No plan touches a road user or passes a line, unless the assumptions exclude the case."""
    for k in PLANS_OF_A_SCENE:
        for row in scene_rows(SEED, number_of(name, 0), only=k):
            assert "contact" not in row or row["excused"], row
            assert not row.get("missed"), row


FOUND = {
    "pulls over before a cyclist who is beside us with little room": (1, 78, 3),
    "backs up askew before a motorcycle in the next lane": (5, 311, 5),
    "drifts by 6 cm a second into a parked van": (5, 7518, 3),
    "drifts into a parked truck while it stops": (5, 7995, 3),
    "drifts into a cyclist who filters past": (5, 9544, 1),
    "pulls over onto somebody who walks along the edge": (6, 3770, 2),
    "drifts into a barrier that is passed at 17 km/h": (5, 9478, 0),
    "lets a motorcycle by and goes on before the car behind it": (8, 3943, 2),
    "lets a cyclist near its nose by, and goes on": (8, 1374, 3),
    "creeps, at 19 km/h, towards a queue 3 m ahead": (9, 1885, 3),
    "backs up askew before one who comes the other way": (10, 8452, 5),
    "creeps, drawn aside, into the corner of a parked van": (10, 6155, 1),
    "stops beyond the end of what is proven, to wait": (11, 9702, 1),
    "drifts into a barrier at 1.2 m/s, past the commit point": (11, 10086, 3),
    "stands in a junction before what follows": (12, 2320, 3),
    "begins 4 m behind a crawler at 20 km/h": (12, 1554, 5),
    "lets go of the brakes before a person who steps off": (12, 8922, 2),
    "drifts into a cone at walking pace": (10, 6855, 0),
    "sets off from rest before a motorcycle that crosses": (5, 10101, 1),
    "starts again and again, 2 cm beside a barrier that its error points to": (31, 1799, 4),
    "brakes gently while it drifts towards a cyclist who filters past": (31, 5096, 2),
}


@pytest.mark.integration
@pytest.mark.parametrize("found", FOUND.values(), ids=FOUND)
def test_what_it_once_found_stays_mended(found):
    seed, scene, k = found
    row = next(row for row in scene_rows(seed, scene, only=k))
    assert "contact" not in row or row["excused"], row


def test_campaign_abort_before_rails_does_not_enter_them():
    """No step ends so close before rails that its abort leads onto them."""
    row = next(row for row in scene_rows(31, 7458, only=5))
    assert not row.get("missed"), row


def sees_contact(numbers):
    """Is somebody touched in one of these scenes? It stops at the first."""
    rows = (row for number in numbers for row in scene_rows(3, number))
    return any("contact" in row and not row["excused"] for row in rows)


def test_the_oracle_sees_a_guard_that_looks_for_no_collision(monkeypatch):
    monkeypatch.setitem(guard_module.CHECKS, Check.COLLISION, lambda case: [])
    assert sees_contact(range(NAMES.index("people"), 45, len(NAMES)))


def test_the_oracle_sees_a_guard_that_never_looks_again(monkeypatch):
    monkeypatch.setattr(guard_module.Guard, "recheck", lambda *_, **__: guard_module.OK)
    assert sees_contact(range(NAMES.index("people"), 45, len(NAMES)))


def test_a_scene_is_made_of_its_number_alone():
    rows = [json.dumps(list(scene_rows(4, 9, judge_only=True))) for _ in range(2)]
    assert rows[0] == rows[1]


def test_a_campaign_goes_on_where_it_was(tmp_path):
    whole = campaign(tmp_path / "whole", 1, 10**6, 3, judge_only=True)
    campaign(tmp_path / "cut", 1, 10**6, 2, judge_only=True)
    file = tmp_path / "cut" / "seed-1.jsonl"
    file.write_text(file.read_text(encoding="utf-8") + '{"place": 2, "scene": 2, "clas', encoding="utf-8")
    assert campaign(tmp_path / "cut", 1, 10**6, 3, judge_only=True) == whole
    assert file.read_text(encoding="utf-8") == (tmp_path / "whole" / "seed-1.jsonl").read_text(encoding="utf-8")


@pytest.mark.integration
def test_campaign_with_two_processes_has_the_same_result(tmp_path):
    """Two processes take turns; the file has the scenes in their order, and ends with the plan that was asked for."""
    classes = ("people", "queue", "slow in a junction")
    one = campaign(tmp_path / "one", 2, 8, classes=classes, jobs=1)
    two = campaign(tmp_path / "two", 2, 8, classes=classes, jobs=2)
    assert one == two and one["counts"]["driven"] >= 8
    assert (tmp_path / "one" / "seed-2.jsonl").read_text(encoding="utf-8") == (
        tmp_path / "two" / "seed-2.jsonl"
    ).read_text(encoding="utf-8")


@pytest.mark.integration
def test_campaign_keeps_contacts_by_cause_and_no_row_without_one(tmp_path, monkeypatch):
    """With a guard that looks for no collision."""
    monkeypatch.setitem(guard_module.CHECKS, Check.COLLISION, lambda case: [])
    data = campaign(tmp_path, 3, 12, classes=("people",))
    assert sum(data["causes"].values()) == len(data["found"]) > 0
    assert data["causes"]["not excused"] == data["counts"]["not excused"] > 0
    assert all(row["visible_s"] >= (row["stop_s"] or 0.0) for row in data["found"])


def test_scene_number_names_its_class_whatever_is_added_later(monkeypatch):
    """The sixteen first classes share the small numbers; each later one has a block of its own."""
    before = [class_of(k)[0] for k in range(64)]
    assert before == [list(CLASSES)[k % 16] for k in range(64)]
    for name in all_classes():
        assert [class_of(number_of(name, k))[0] for k in (0, 7, 4000)] == [name] * 3
    monkeypatch.setitem(LATER, "one more", (99, lambda draw: Setting(STREET)))
    assert class_of(99 * BLOCK + 3)[0] == "one more" and [class_of(k)[0] for k in range(64)] == before
    with pytest.raises(ValueError, match="block 99 is taken"):
        scene_class("another", block=99)(lambda draw: Setting(STREET))


def test_bodies_touch_where_they_overlap_and_nowhere_else():
    car = Body(0.0, 0.0, 0.0, 4.0, 2.0)
    assert distance(car, Body(5.0, 0.0, 0.0, 4.0, 2.0)) == pytest.approx(1.0)
    assert distance(car, Body(0.0, 3.0, math.pi / 2, 2.0, 4.0)) == pytest.approx(1.0)
    assert distance(car, Body(3.9, 0.0, 0.0, 4.0, 2.0)) == 0.0
    assert part_touched(car, Body(3.9, 0.0, 0.0, 4.0, 2.0)) == "front"
    assert part_touched(car, Body(0.0, 1.9, 0.0, 2.0, 2.0)) == "side"
    assert part_touched(car, Body(-3.9, 0.0, 0.0, 4.0, 2.0)) == "rear"


def path(points, mps=4.0):
    return Execute(
        behavior=KeepLane(distance_m=50.0, speed_mps=5.0),
        path=tuple(PathPoint(x_m=x, y_m=y, speed_mps=mps) for x, y in points),
    )


def test_oracle_ego_rear_axle_does_not_slip():
    """The rear axle never slips, and the drift is the requested one."""
    ego = Ego(0.0, 0.0, 0.4, 0.0, Manner(drift=0.7, drift_rate=0.2))
    order = path([(0.5 * k, 0.0) for k in range(160)])
    for k in range(300):
        x, y, yaw = ego.x, ego.y, ego.yaw
        ego.obey(order, 0.05 * k, 0.05)
        lever = WHEELBASE_M / 2
        moved = (
            (ego.x - lever * math.cos(ego.yaw) - x + lever * math.cos(yaw)),
            (ego.y - lever * math.sin(ego.yaw) - y + lever * math.sin(yaw)),
        )
        middle = (yaw + ego.yaw) / 2
        assert abs(moved[1] * math.cos(middle) - moved[0] * math.sin(middle)) < 1e-6
    assert ego.y == pytest.approx(0.7, abs=0.1) and ego.speed > 3.0


def test_oracle_ego_brakes_only_as_ordered_after_lag():
    """The ego brakes as hard as ordered, after its lag, and for nothing else."""
    ego = Ego(0.0, 0.0, 0.0, 4.0, Manner(lag=0.2))
    for k in range(10):
        ego.obey(Execute(behavior=Wait(duration_s=1.0), brake_mps2=6.0), 0.05 * k, 0.05)
    assert ego.speed == pytest.approx(4.0 - 6.0 * 0.3, abs=0.31)
    driving_on = Ego(0.0, 0.0, 0.0, 4.0, Manner())
    driving_on.obey(path([(0.5 * k, 0.0) for k in range(60)]), 0.0, 0.05, room=0.0)
    assert driving_on.speed >= 4.0


def world(*others, **more):
    return World(Setting(STREET, list(others), **more), Manner())


def test_oracle_follower_reacts_after_1_s_as_assumed():
    """A follower reacts after one second and brakes no harder than assumed."""
    other = driving("other", STREET, 30.0, 3.5, 10.0, "comes up in the lane entered")
    there = world(other, ego_d=2.5, ego_speed=1.0)
    there.others[0].was_behind = False
    speeds = []
    for _ in range(60):
        speeds.append(other.v)
        other.step(there, 0.05)
        there.t += 0.05
    assert speeds[15] == 10.0 and speeds[-1] < 10.0
    assert max(a - b for a, b in itertools.pairwise(speeds)) <= 4.5 * 0.05 + 1e-9


def test_who_may_step_off_does_so_before_our_front_only():
    walker = at_the_kerb("walker", 75.0, -3.0, trigger=4.0)
    there = world(walker, ego_s=60.0)
    walker.step(there, 0.05)
    assert not walker.walks
    there = world(replace(walker), ego_s=75.0 - LENGTH_M / 2 - 2.0)
    there.others[0].step(there, 0.05)
    assert there.others[0].walks and there.others[0].speed == pytest.approx(1.4)


def test_campaign_each_class_has_scenes_without_initial_contact():
    for name in all_classes():
        possible = [World(setting_of(8, number_of(name, k))[1], Manner()).is_possible() for k in range(6)]
        assert any(possible), name
    assert len(all_classes()) >= 20


@pytest.mark.parametrize("name", LATER)
def test_later_class_has_accepted_plans(name):
    """A class in which every plan is refused would test nothing."""
    rows = [row for k in range(4) for row in scene_rows(9, number_of(name, k), judge_only=True)]
    assert sum(row["accepted"] for row in rows) >= 3


@pytest.mark.integration
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_campaign_slow_class_vehicles_appear_far_and_meet_ego(seed):
    """In the slow class, vehicles come into sight from afar and many meet the ego.

    The ego drives straight on at the scene's pace. Most vehicles come into sight 45 to 90 m away.
    """
    met = far = 0
    for k in range(12):
        setting = setting_of(seed, number_of("slow in a junction", k))[1]
        there, first = World(setting, Manner()), {}
        pace = setting.ego_speed or 1.0
        for _ in range(500):
            there.step(path([(60.0 + 0.5 * k, 0.0) for k in range(200)], pace))
            for other in there.others:
                if other.name not in first and there.sees(other):
                    first[other.name] = math.hypot(other.body.x - there.ego.x, other.body.y - there.ego.y)
            if there.touched() is not None:
                met += 1
                break
        far += 45.0 < first["crosser0"] < 90.0
    assert met >= 4 and far >= 9
