"""What a vehicle with sensors is told of what is far ahead: never less than what may come."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("carla")

from towns import demo_road, town

from stucksolver.scene import EgoState, ObjectKind
from stucksolver.scene.frenet import RoadFrame
from stucksolver_carla.drivers.behavior.nearby_objects import FIRST_FAR_ID
from stucksolver_perception.camera.camera_sight_distance import CameraSight, SightModel
from stucksolver_perception.camera.far_detector import FarDetections
from stucksolver_perception.carla.far_vehicle_reports import (
    FASTEST_MPS,
    NEAREST_M,
    FarVehicleReports,
    to_reported_track,
)
from stucksolver_perception.carla.lane_sight import SensorLaneSight
from stucksolver_perception.carla.perceived_objects import PerceivedTracker, actor_proxies, to_nearby_objects
from stucksolver_perception.cycle_data import PerceptionResult
from stucksolver_perception.far_tracking import FIRST_ID, FarTrack
from stucksolver_perception.far_view import FarImage, FarView
from stucksolver_perception.free_space import AZIMUTHS, CELL_M, FreeSpace
from stucksolver_perception.measurements import Floats, PoseEstimate
from stucksolver_perception.rig import load_rig

RIG = load_rig()
ARC_M = 250.0
ROAD = demo_road((3, -1, 20.0), (3, -1, 400.0))
FRAME = RoadFrame(ROAD.slice(ARC_M, None))
MAP = town("demo_town")
DAY = np.array([150.0, 30.0])
NOTHING = np.zeros((0, 7))


def lane_d(name: str) -> float:
    lane = next(item for item in FRAME.lanes if item.strip.id.startswith(name))
    return lane.at(ARC_M)[1]


OWN_D, ONCOMING_D = lane_d("own"), lane_d("left1-oncoming")


def place(ahead_m: float, d: float = OWN_D) -> tuple[float, float, float]:
    x, y, heading = FRAME.to_local(np.array([ARC_M + ahead_m]), np.array([d]))
    return float(x[0]), float(y[0]), float(heading[0])


def pose(time_s: float = 1.0) -> PoseEstimate:
    x, y, yaw = place(0.0)
    return PoseEstimate(time_s, x, y, 0.0, yaw, 0.0, 0.0, np.eye(4) * 0.01)


def far(
    ahead_m: float, d: float, rate: float = 0.0, rate_sd: float = 15.0, sd: float = 8.0, towards: float = 0.5
) -> FarTrack:
    """One at this place of the road, as seen from the ego's place."""
    x, y, _ = place(ahead_m, d)
    ego = pose()
    bearing, away = math.atan2(y - ego.y_m, x - ego.x_m), math.hypot(x - ego.x_m, y - ego.y_m)
    at = {"x_m": x, "y_m": y, "bearing_rad": bearing, "range_m": away, "range_sd_m": sd}
    times = {"first_seen_s": 0.0, "last_seen_s": 1.0, "hits": 5}
    return FarTrack(FIRST_ID, 1.0, 0, 0.9, **at, rate_mps=rate, rate_sd_mps=rate_sd, towards=towards, **times)


def told(track: FarTrack) -> tuple[float, float, float, float]:
    """Meters ahead and offset of the track that is made of it, and its velocity along and across the road."""
    made = to_reported_track(track, MAP, 0.0)
    assert made is not None
    s, d, heading = (float(item[0]) for item in FRAME.to_road(np.array([[made.x_m, made.y_m]])))
    c, n = math.cos(heading), math.sin(heading)
    return s - ARC_M, d, made.vx_mps * c + made.vy_mps * n, made.vy_mps * c - made.vx_mps * n


# ---- what is told of vehicles


def test_who_comes_is_told_nearer_and_quicker_than_measured() -> None:
    ahead, d, along, across = told(far(100.0, ONCOMING_D, rate=-12.0, rate_sd=2.0, sd=8.0))
    assert ahead == pytest.approx(100.0 - 16.0, abs=1.0)
    assert d == pytest.approx(ONCOMING_D, abs=0.1)
    assert along == pytest.approx(-16.0, abs=0.2)
    assert abs(across) < 0.1


def test_far_oncoming_unmeasured_is_reported_at_maximum_speed() -> None:
    """A vehicle in an oncoming lane without a measured speed is reported as fast as traffic can be."""
    assert told(far(100.0, ONCOMING_D, rate=0.0, rate_sd=15.0))[2] == pytest.approx(-30.0, abs=0.3)
    assert told(far(100.0, ONCOMING_D, rate=-20.0, rate_sd=15.0))[2] == pytest.approx(-FASTEST_MPS, abs=0.3)


def test_far_oncoming_stopped_is_reported_approaching_within_error() -> None:
    """A stopped vehicle in an oncoming lane is reported as approaching no faster than the error (2 sd)."""
    assert told(far(100.0, ONCOMING_D, rate=0.0, rate_sd=1.0))[2] == pytest.approx(-2.0, abs=0.1)


def test_who_surely_goes_away_in_an_oncoming_lane_goes_away() -> None:
    goes = replace(far(100.0, ONCOMING_D, rate=8.0, rate_sd=1.5), hits=10)
    assert told(goes)[2] == pytest.approx(8.0, abs=0.1)


def test_far_oncoming_few_detections_do_not_recede() -> None:
    """A few detections do not make a vehicle in an oncoming lane drive away."""
    goes = replace(far(100.0, ONCOMING_D, rate=20.0, rate_sd=4.0), hits=3)
    assert told(goes)[2] == pytest.approx(0.0, abs=0.1)


def test_far_lead_is_reported_only_with_known_rate() -> None:
    """A lead vehicle is not reported until its speed is known."""
    assert to_reported_track(far(80.0, OWN_D, rate=5.0, rate_sd=8.0), MAP, 0.0) is None
    assert told(far(80.0, OWN_D, rate=5.0, rate_sd=2.0))[2] == pytest.approx(5.0, abs=0.1)


def test_far_own_lane_approach_needs_certain_rate() -> None:
    """In the ego's lane, a vehicle is reported as approaching only if its speed is certain."""
    assert told(far(80.0, OWN_D, rate=-2.0, rate_sd=2.0))[2] == 0.0
    assert told(far(80.0, OWN_D, rate=-10.0, rate_sd=2.0))[2] == pytest.approx(-14.0, abs=0.2)


def test_who_is_on_no_lane_is_not_told_of() -> None:
    assert to_reported_track(far(100.0, 40.0, rate=-10.0, rate_sd=1.0), MAP, 0.0) is None


def test_nobody_is_told_to_be_where_the_lidar_sees_everything() -> None:
    assert told(far(50.0, ONCOMING_D, rate=-10.0, rate_sd=2.0, sd=25.0))[0] == pytest.approx(NEAREST_M, abs=1.5)
    assert to_reported_track(far(NEAREST_M - 1.0, ONCOMING_D, rate=-10.0, rate_sd=2.0), MAP, 0.0) is None


def test_both_drivers_and_the_solver_are_told() -> None:
    percept = seen_from(far_tracks=(far(100.0, ONCOMING_D, rate=-12.0, rate_sd=2.0),))
    world = SimpleNamespace(get_map=lambda: MAP)
    eyes: Any = SimpleNamespace(
        percept=percept, now_s=1.5, vehicle=SimpleNamespace(get_world=lambda: world, get_speed_limit=lambda: 50.0)
    )
    body = to_nearby_objects(FarVehicleReports(MAP).reported_tracks(percept), 1.5)
    ego: Any = SimpleNamespace(x=0.0, y=0.0, yaw=0.0, half_length=2.4, half_width=1.0, speed=0.0)
    tracker = PerceivedTracker(eyes)
    tracker.watch = lambda ego, now_s: body  # type: ignore[method-assign]
    (thing,) = tracker.update(ego, 1.5)
    assert body.actor_id == (FIRST_ID,)
    assert thing.id == str(FIRST_ID)
    assert thing.kind is ObjectKind.CAR
    # Half a second later it is 8 m nearer than it was told to be at the time of the percept.
    (s, *_), *_ = FRAME.to_road(np.array([[thing.x_m, thing.y_m]]))
    assert s - ARC_M == pytest.approx(100.0 - 16.0 - 8.0, abs=1.0)
    assert (body.x[0], -body.y[0]) == pytest.approx((thing.x_m, thing.y_m))
    assert [proxy.type_id for proxy in actor_proxies(percept, [FIRST_ID])] == ["vehicle.sensed"]


# ---- how far lanes are seen


def space(reach_m: float, blocked_m: float = math.inf, only: float | None = None) -> FreeSpace:
    """The ground seen so far all around, and something tall at a distance, in all directions or in one (rad)."""
    cells = np.zeros((AZIMUTHS, 170), bool)
    cells[:, int(3.0 / CELL_M) : int(reach_m / CELL_M)] = True
    blocked = np.full(AZIMUTHS, math.inf)
    where = slice(None) if only is None else int((only + math.pi) / math.tau * AZIMUTHS)
    blocked[where] = blocked_m
    return FreeSpace(cells, blocked, np.zeros(AZIMUTHS), (0.0, 0.0))


def recall() -> SightModel:
    edges = {"brightness": [], "contrast": []}
    found = [[400, 400]] * 6 + [[0, 400]] * 2
    bins = [25.0 * k for k in range(1, 10)]
    rest = {"look_edges": edges, "repeated_miss": [20, 100]}
    return SightModel.from_card({"bins_m": bins, "recall": {"vehicle": [found]}, **rest})


def seen_from(
    free_space: FreeSpace | None = None, far_tracks: tuple[FarTrack, ...] = (), blockers: Floats = NOTHING
) -> PerceptionResult:
    none = np.zeros(0)
    nobody = FarDetections(1.0, none, none, none, none, none, np.zeros(0, np.int64), none, DAY)
    view = FarView((FarImage(nobody, pose(), blockers),), CameraSight(RIG.camera, recall()), recall())
    about = {"tracks": (), "attributes": {}, "lights": {}, "far": nobody, "picture_time_s": 1.0}
    return PerceptionResult(pose=pose(), seen=free_space or space(50.0), far_tracks=far_tracks, far_view=view, **about)


def sight(percept: PerceptionResult) -> dict[str, tuple[float, float]]:
    eyes: Any = SimpleNamespace(percept=percept)
    x, y, yaw = place(0.0)
    ego = EgoState(x_m=x, y_m=y, yaw_rad=yaw, speed_mps=0.0, length_m=4.8, width_m=1.9)
    found = SensorLaneSight(eyes, FRAME).of_lanes(ego, ARC_M, ())
    return {item.lane_id.split("@")[0]: (item.ahead_m, item.behind_m) for item in found}


def test_sight_camera_extends_lidar_in_oncoming_lane() -> None:
    """The camera extends the sight of the oncoming lane beyond the last ground return of the LiDAR."""
    both, lidar = sight(seen_from()), sight(replace(seen_from(), far_view=None))
    assert lidar["left1-oncoming"][0] == pytest.approx(50.0, abs=2.0)
    assert both["left1-oncoming"][0] > 100.0


def test_behind_sight_is_the_lidars() -> None:
    both, lidar = sight(seen_from()), sight(replace(seen_from(), far_view=None))
    assert [item[1] for item in both.values()] == [item[1] for item in lidar.values()]


def test_sight_camera_ends_at_tall_lidar_object() -> None:
    """The camera's sight ends at an object that the LiDAR measured as tall."""
    assert sight(seen_from(space(50.0, blocked_m=50.0)))["left1-oncoming"][0] < 52.0
    ahead = sight(seen_from(space(50.0, blocked_m=80.0)))["left1-oncoming"][0]
    assert 70.0 < ahead < 81.0


def test_sight_tracked_tall_object_occludes_only_its_box() -> None:
    """A tall tracked object occludes only what its box occludes from the camera."""
    tall = seen_from(space(50.0, blocked_m=20.0))
    assert sight(tall)["left1-oncoming"][0] < 52.0
    tracked = replace(tall, unknown_m=np.full(AZIMUTHS, math.inf))
    assert sight(tracked)["left1-oncoming"][0] > 100.0
    partly = replace(tall, unknown_m=np.full(AZIMUTHS, 80.0))
    assert 70.0 < sight(partly)["left1-oncoming"][0] < 81.0


def test_something_tall_aside_of_a_lane_ends_no_sight() -> None:
    assert sight(seen_from(space(50.0, blocked_m=20.0, only=0.8)))["left1-oncoming"][0] > 100.0


def test_sight_behind_tracked_bus_ends() -> None:
    aside = ONCOMING_D - OWN_D
    bus = np.array([[60.0, aside, 1.6, 12.0, 2.5, 3.2, 0.0]])
    assert sight(seen_from(blockers=bus))["left1-oncoming"][0] < 75.0


def test_sight_recent_view_shrinks_by_possible_entries() -> None:
    """Space that was visible a moment ago counts as free, less where a vehicle may have entered since."""
    eyes: Any = SimpleNamespace(percept=replace(seen_from(space(50.0)), far_view=None))
    x, y, yaw = place(0.0)
    ego = EgoState(x_m=x, y_m=y, yaw_rad=yaw, speed_mps=0.0, length_m=4.8, width_m=1.9)
    looker = SensorLaneSight(eyes, FRAME)

    def oncoming(time_s: float, reach_m: float) -> float:
        seen = replace(seen_from(space(reach_m)), far_view=None, pose=pose(time_s))
        eyes.percept = seen
        found = looker.of_lanes(ego, ARC_M, ())
        return next(item.ahead_m for item in found if item.lane_id.startswith("left1-oncoming"))

    first = oncoming(1.0, 50.0)
    later = oncoming(1.3, 8.0)
    assert 8.0 < later < first - 0.3 * 5.0
    assert oncoming(2.5, 8.0) < 10.0, "a second later nothing of it is known"


def test_far_tracks_first_id_is_same_in_driver():
    """The driver has the same first id for tracks of the camera alone."""
    assert FIRST_FAR_ID == FIRST_ID
