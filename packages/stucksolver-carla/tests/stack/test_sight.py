"""How far lanes are seen: to the range on a straight road, less in bends and behind what is tall."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("carla")

from towns import demo_road

from stucksolver.scene import EgoState, LaneSight, ObjectKind, TrackedObject
from stucksolver.scene.frenet import RoadFrame
from stucksolver_carla.stack.line_of_sight import STEP_M, SightLines

STRAIGHT = ((3, -1, 20.0), (3, -1, 400.0))
CORNER = ((3, -1, 250.0), (5, -1, 60.0))
STREET = ((11, -1, 20.0), (13, -1, 200.0))


class Lookout:
    """An ego at an arc length of a road, and what it sees of the lanes there."""

    def __init__(self, ends, arc_m: float, range_m: float = 150.0) -> None:
        self.frame = RoadFrame(demo_road(*ends).slice(arc_m, None))
        self.arc_m = arc_m
        self.sight = SightLines(self.frame, range_m)

    def place(self, ahead_m: float, left_m: float = 0.0) -> tuple[float, float, float]:
        x, y, heading = self.frame.to_local(np.array([self.arc_m + ahead_m]), np.array([left_m]))
        return float(x[0]), float(y[0]), float(heading[0])

    def thing(self, ahead_m: float, height_m: float, left_m: float = 0.0) -> TrackedObject:
        x, y, yaw = self.place(ahead_m, left_m)
        size = {"length_m": 8.0, "width_m": 2.5, "height_m": height_m}
        motion = {"vx_mps": 0.0, "vy_mps": 0.0}
        return TrackedObject(id="1", kind=ObjectKind.TRUCK, x_m=x, y_m=y, yaw_rad=yaw, **motion, **size)

    def told(self, *things: TrackedObject) -> tuple[LaneSight, ...]:
        """What the sight lines say."""
        x, y, yaw = self.place(0.0)
        ego = EgoState(x_m=x, y_m=y, yaw_rad=yaw, speed_mps=0.0, length_m=4.8, width_m=1.9)
        return self.sight.of_lanes(ego, self.arc_m, things)

    def seen(self, *things: TrackedObject) -> dict[str, tuple[float, float]]:
        """(ahead, behind) of each lane by its name, the one that begins nearest where several have the same."""
        found = self.told(*things)
        starts = {lane.strip.id: lane.start_m for lane in self.frame.lanes}
        found = sorted(found, key=lambda item: starts[item.lane_id], reverse=True)
        return {item.lane_id.split("@")[0]: (item.ahead_m, item.behind_m) for item in found}


def test_sight_straight_road_reaches_range_on_all_lanes():
    """On a straight road, every lane and the shoulder are visible up to the range.

    The shoulder on the ego's side: a vehicle that pulls over needs sight of the place to stop, and beyond.
    """
    seen = Lookout(STRAIGHT, 250.0).seen()
    assert set(seen) == {"own", "left1-oncoming", "left2-oncoming", "right1-driving", "right2-shoulder"}
    for ahead, behind in seen.values():
        assert ahead == pytest.approx(150.0, abs=STEP_M)
        # The slice of an episode ends 150 m behind.
        assert behind == pytest.approx(150.0, abs=STEP_M)


def test_a_bend_cuts_the_sight():
    before = Lookout(CORNER, 300.0)
    straight_m = Lookout(STRAIGHT, 250.0).seen()["own"][0]
    for lane, (ahead, _) in before.seen().items():
        assert ahead < straight_m - 20.0, lane


def test_sight_bend_occludes_more_when_near():
    """The inside of a bend occludes more the nearer it is."""
    far, near = (Lookout(CORNER, arc).seen()["own"][0] for arc in (220.0, 330.0))
    assert near < far < 150.0


def test_a_tall_truck_hides_what_is_behind_it():
    lookout = Lookout(STREET, 150.0)
    seen = lookout.seen(lookout.thing(20.0, 3.5))
    assert seen["own"][0] < 20.0
    # From behind the truck the oncoming lane is seen only up to where the line of sight grazes its corner.
    assert 10.0 < seen["left1-oncoming"][0] < 60.0
    assert seen["left1-oncoming"][0] < lookout.seen()["left1-oncoming"][0] - 50.0


def test_a_sedan_hides_nothing():
    lookout = Lookout(STREET, 150.0)
    assert lookout.seen(lookout.thing(20.0, 1.5)) == lookout.seen()


def test_a_truck_behind_hides_the_lane_behind_only():
    lookout = Lookout(STRAIGHT, 250.0)
    free, seen = lookout.seen(), lookout.seen(lookout.thing(-20.0, 3.5))
    assert seen["own"][1] < 20.0 < free["own"][1]
    assert seen["own"][0] == free["own"][0]


def test_a_truck_in_a_lane_beside_hides_that_lane():
    lookout = Lookout(STRAIGHT, 250.0)
    seen = lookout.seen(lookout.thing(30.0, 3.5, left_m=3.5))
    assert seen["left1-oncoming"][0] < 30.0
    assert seen["own"] == lookout.seen()["own"]


def test_a_lane_is_not_seen_beyond_its_end():
    road = demo_road((11, 1, 60.0), (1, -1, 60.0))
    lookout = Lookout(((11, 1, 60.0), (1, -1, 60.0)), road.start_arc + 20.0)
    lanes = {lane.strip.id.split("@")[0]: lane for lane in lookout.frame.lanes if lane.start_m < lookout.arc_m}
    oncoming = lanes["left1-oncoming"]
    assert lookout.seen()["left1-oncoming"][0] <= oncoming.end_m - lookout.arc_m < 45.0


def test_sight_oncoming_lane_is_visible_through_junction():
    """An oncoming lane is visible through the junction before it unless an object occludes it."""
    road = demo_road((11, 1, 60.0), (1, -1, 60.0))
    lookout = Lookout(((11, 1, 60.0), (1, -1, 60.0)), road.start_arc + 20.0)
    further = [lane for lane in lookout.frame.lanes if lane.start_m > lookout.arc_m and "oncoming" in lane.strip.id]
    told = {item.lane_id: item for item in lookout.told()}
    assert further
    for lane in further:
        assert told[lane.strip.id].behind_m == 0.0
        assert told[lane.strip.id].ahead_m <= lane.end_m - lookout.arc_m
        wall = lookout.thing(25.0, 3.5, left_m=lane.at(lane.start_m)[1])
        assert {item.lane_id: item for item in lookout.told(wall)}[lane.strip.id].ahead_m < 25.0
