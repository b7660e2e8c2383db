"""Criteria about the way along the route, on a straight one."""

from __future__ import annotations

import pytest

pytest.importorskip("carla")

from judged import drive, moment, straight

from stucksolver_eval.criteria.agent_blocked import Blocked
from stucksolver_eval.criteria.in_route import InRoute
from stucksolver_eval.criteria.min_speed import MinSpeed
from stucksolver_eval.criteria.route_completion import RouteCompletion
from stucksolver_eval.criteria.route_timeout import RouteTimeout, TickRuntime


def test_completion_is_the_share_up_to_the_last_point_passed() -> None:
    criterion = RouteCompletion(straight(200))
    drive(criterion, 0.0, 50.5)
    assert (criterion.percentage, criterion.complete) == (25.0, False)


def test_route_completion_beyond_99_percent_near_end_is_complete() -> None:
    """A route is complete when more than 99 % are driven and its end is near."""
    criterion = RouteCompletion(straight(200))
    drive(criterion, 0.0, 198.5)
    assert (criterion.percentage, criterion.complete) == (99.0, False)
    drive(criterion, 198.5, 199.5)
    assert (criterion.percentage, criterion.complete) == (100.0, True)


def test_a_short_cut_is_no_completion() -> None:
    criterion = RouteCompletion(straight(200))
    criterion.update(moment(0.0, 150.0))
    # Three points are looked at in a tick, no more.
    assert criterion.index == 2


@pytest.mark.parametrize(("y", "fails"), [(29.9, False), (30.1, True)])
def test_thirty_metres_beside_the_route_is_off_it(y: float, fails: bool) -> None:
    criterion = InRoute(straight(100))
    criterion.update(moment(0.0, 0.0, y))
    assert (criterion.ends_route is not None) is fails
    assert len(criterion.infractions) == fails


@pytest.mark.parametrize(("to_m", "fails"), [(29.0, False), (32.0, True)])
def test_in_route_30_percent_beyond_15_m_fails(to_m: float, fails: bool) -> None:
    """More than 30 % of the route at a lateral distance above 15 m ends the route."""
    criterion = InRoute(straight(100))
    drive(criterion, 0.0, to_m, y=16.0)
    assert (criterion.ends_route is not None) is fails


def test_a_suspended_deviation_is_none() -> None:
    criterion = InRoute(straight(100))
    criterion.update(moment(0.0, 0.0, 40.0, suspended=frozenset({"route_deviation"})))
    assert criterion.ends_route is None


def test_sixty_seconds_at_a_stand_end_a_route() -> None:
    criterion = Blocked()
    criterion.update(moment(0.0, 0.0, speed_mps=0.05))
    criterion.update(moment(60.0, 0.0, speed_mps=0.05))
    assert criterion.ends_route is None
    criterion.update(moment(60.1, 0.0, speed_mps=0.05))
    assert criterion.ends_route == "Agent got blocked"


def test_a_suspended_stand_begins_anew_when_it_counts_again() -> None:
    criterion = Blocked()
    criterion.update(moment(0.0, 0.0, speed_mps=0.0))
    criterion.update(moment(100.0, 0.0, speed_mps=0.0, suspended=frozenset({"blocked"})))
    criterion.update(moment(160.0, 0.0, speed_mps=0.0))
    assert criterion.ends_route is None
    criterion.update(moment(160.1, 0.0, speed_mps=0.0))
    assert criterion.ends_route is not None


def test_min_speed_is_checked_at_twentieths_and_last_listed_twice() -> None:
    """Speed is compared with the traffic at each twentieth of the route, and the last value is listed twice."""
    criterion = MinSpeed(straight(200))
    for k in range(400):
        criterion.update(moment(k * 0.05, k * 0.5, speed_mps=10.0, background_mps=(4.0, 12.0)))
    criterion.finish()
    texts = [i.text for i in criterion.infractions]
    # A checkpoint is noted when more than 10 m were driven since the last: every 11 m on points a meter apart.
    assert len(texts) == 200 // 11 + 2
    assert texts[-1] == texts[-2]
    assert all("125.0%" in text for text in texts)
    assert criterion.stuck_end is None


def test_without_traffic_the_speed_counts_as_100_percent() -> None:
    criterion = MinSpeed(straight(20))
    drive(criterion, 0.0, 3.0)
    assert "100.0%" in criterion.infractions[0].text


def test_a_stuck_end_has_no_entry_but_is_known() -> None:
    criterion = MinSpeed(straight(200))
    for k in range(100):
        criterion.update(moment(k * 0.05, 2.0, speed_mps=1.0, background_mps=(10.0,)))
    criterion.finish()
    assert criterion.infractions == []
    assert criterion.stuck_end == 10.0


class SlowStreet:
    def get_speed_limit(self) -> float:
        return 36.0


def test_the_time_allowed_grows_with_the_way_driven() -> None:
    criterion = RouteTimeout(straight(100), SlowStreet())
    drive(criterion, 0.0, 50.5)
    # 300 s, and 50 m at a tenth of 10 m/s.
    criterion.update(moment(349.9, 50.6))
    assert criterion.ends_route is None
    criterion.update(moment(350.1, 50.6))
    assert criterion.ends_route == "Agent timed out"


def test_after_4000_ticks_a_route_is_over() -> None:
    criterion = TickRuntime()
    for k in range(4000):
        criterion.update(moment(k * 0.05, 0.0))
    assert criterion.ends_route is None
    criterion.update(moment(200.0, 0.0))
    assert (criterion.ends_route, criterion.infractions) == ("TickRuntime", [])


def test_ticks_while_it_is_suspended_do_not_count() -> None:
    criterion = TickRuntime()
    for k in range(3000):
        criterion.update(moment(k * 0.05, 0.0, suspended=frozenset({"tick_runtime"})))
    for k in range(4000):
        criterion.update(moment(150.0 + k * 0.05, 0.0))
    assert criterion.ends_route is None
    criterion.update(moment(350.0, 0.0))
    assert criterion.ends_route == "TickRuntime"
