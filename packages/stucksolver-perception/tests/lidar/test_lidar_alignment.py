"""A LiDAR that is turned is noticed while the vehicle drives, and one that is not is never accused."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from stucksolver_perception.lidar.lidar_miscalibration import LidarAlignment
from stucksolver_perception.measurements import Floats, LidarSweep, PoseEstimate
from stucksolver_perception.rig import load_rig

RIG = load_rig().lidar
TICK_S = 0.05
REAR_AXLE_M = 1.45
REACH_M = 45.0
NOBODY = np.zeros((0, 5))
HEALTHY_DEG = 0.4
"""A healthy LiDAR's matches are no further off than this."""


def line(start: tuple[float, float], end: tuple[float, float], step_m: float = 0.15) -> Floats:
    """(n, 2): places along a wall."""
    return np.linspace(start, end, max(2, round(math.dist(start, end) / step_m)))


def street(seed: int = 0, length_m: float = 260.0) -> Floats:
    """(n, 2): houses of several depths on both sides of a road along x, side walls included, and posts."""
    random, walls = np.random.default_rng(seed), []
    for side in (-1.0, 1.0):
        x = -60.0
        while x < length_m:
            front, back, wide = side * random.uniform(7.0, 12.0), side * 20.0, random.uniform(6.0, 16.0)
            walls += [line((x, front), (x + wide, front)), line((x, front), (x, back))]
            walls.append(line((x + wide, front), (x + wide, back)))
            x += wide + random.uniform(3.0, 9.0)
        posts = np.column_stack([np.arange(-50.0, length_m, 17.0), np.full(19 if length_m == 260.0 else 1, side * 5.0)])
        walls.append(np.repeat(posts, 4, axis=0) + random.uniform(-0.1, 0.1, (4 * len(posts), 2)))
    return np.concatenate(walls)


def ring(radius_m: float = 60.0) -> Floats:
    """(n, 2): houses around a circle on which one drives to the left from the origin."""
    random, walls = np.random.default_rng(4), []
    for way in np.arange(0.0, math.tau, 0.16):
        for aside in (random.uniform(8.0, 12.0), -random.uniform(8.0, 12.0)):
            at = np.array([0.0, radius_m]) + (radius_m + aside) * np.array([math.sin(way), -math.cos(way)])
            along = np.array([math.cos(way), math.sin(way)]) * random.uniform(2.0, 4.5)
            across = np.array([math.sin(way), -math.cos(way)]) * math.copysign(4.0, aside)
            walls += [line(tuple(at - along), tuple(at + along)), line(tuple(at + along), tuple(at + along + across))]
    return np.concatenate(walls)


@dataclass
class Drive:
    """A vehicle with wheels, a gyro and a LiDAR, in a world of upright walls on level ground."""

    walls: Floats
    speed_mps: Callable[[float], float] = lambda _: 8.0
    rate_rps: Callable[[float], float] = lambda _: 0.0
    turned_deg: Callable[[float], float] = lambda _: 0.0
    """How far the LiDAR is turned to the left, by the distance driven."""
    gyro_offset_rps: float = 0.0
    gyro_noise_rps: float = 0.001
    rear_axle_m: float = REAR_AXLE_M
    slip_per_mps2: float = 0.0
    """How far the body slips to the outside, in radians per m/s2 of lateral acceleration."""
    others: Callable[[float], Floats] = lambda _: np.zeros((0, 2))
    """Walls that move, at a time, in the world."""
    others_known: Callable[[float], Floats] = lambda _: NOBODY
    """Footprints of these in the world: x, y, yaw, length, width."""
    seed: int = 0
    alignment: LidarAlignment = field(default_factory=lambda: LidarAlignment(RIG))
    matches: list[float] = field(default_factory=list)
    """What single matches said (degrees)."""
    noticed_m: float | None = None
    """The distance driven when it was noticed."""

    def go(self, meters: float = 120.0, most_s: float = 60.0) -> Drive:
        """Drive until it is noticed, or to the end."""
        random = np.random.default_rng(self.seed)
        x = y = yaw = driven = t = 0.0
        while driven < meters and t < most_s and self.noticed_m is None:
            t += TICK_S
            speed, rate = self.speed_mps(t), self.rate_rps(t)
            slip = -self.slip_per_mps2 * speed * rate
            middle, aside = yaw + rate * TICK_S / 2.0, self.rear_axle_m * rate + speed * math.tan(slip)
            x += (speed * math.cos(middle) - aside * math.sin(middle)) * TICK_S
            y += (speed * math.sin(middle) + aside * math.cos(middle)) * TICK_S
            yaw, driven = yaw + rate * TICK_S, driven + abs(speed) * TICK_S
            told = rate + self.gyro_offset_rps + random.normal(0.0, self.gyro_noise_rps)
            fix = random.normal(0.0, 0.3, 2)  # the position jumps with the satellites
            wheels = speed + random.normal(0.0, 0.05)
            pose = PoseEstimate(t, x + fix[0], y + fix[1], 0.0, yaw, wheels, told, np.eye(4))
            self.alignment.add(self._sweep(random, t, (x, y, yaw), self.turned_deg(driven)), pose)
            match = self.alignment.look(self._moving(t, (x, y, yaw)))
            if match is not None:
                self.matches.append(math.degrees(match.turned_rad))
            if self.alignment.turned_rad is not None:
                self.noticed_m = driven
        return self

    @property
    def told_deg(self) -> float:
        """What is said in the end."""
        assert self.alignment.turned_rad is not None
        return math.degrees(self.alignment.turned_rad)

    def _sweep(
        self, random: np.random.Generator, t: float, place: tuple[float, float, float], turned_deg: float
    ) -> LidarSweep:
        """Half of a turn: the left side on odd ticks, the right one on even ones."""
        seen = into(np.concatenate([self.walls, self.others(t)]), place)
        half = seen[:, 1] > 0.0 if round(t / TICK_S) % 2 else seen[:, 1] <= 0.0
        seen = seen[half & (np.hypot(*seen.T) < REACH_M)]
        seen = np.repeat(seen, 5, axis=0)[random.uniform(size=5 * len(seen)) < 0.55]
        seen += random.normal(0.0, 0.02, seen.shape)
        ground = random.uniform(-30.0, 30.0, (1500, 2))
        height = np.concatenate([random.uniform(0.0, 3.5, len(seen)), np.zeros(len(ground))])
        foot, turn = np.array([RIG.mount.x_m, RIG.mount.y_m]), math.radians(turned_deg)
        # What a LiDAR sees that is turned to the left is turned to the right.
        points = into(np.concatenate([seen, ground]) - foot, (0.0, 0.0, turn)) + foot
        return LidarSweep(t, np.column_stack([points, height, np.full(len(points), 0.5)]).astype(np.float32))

    def _moving(self, t: float, place: tuple[float, float, float]) -> Floats:
        known = self.others_known(t)
        if not len(known):
            return NOBODY
        return np.column_stack([into(known[:, :2], place), known[:, 2] - place[2], known[:, 3:]])


def into(points: Floats, place: tuple[float, float, float]) -> Floats:
    """Points (n, 2) of the world as seen from a place."""
    cos, sin = math.cos(place[2]), math.sin(place[2])
    dx, dy = points[:, 0] - place[0], points[:, 1] - place[1]
    return np.stack([dx * cos + dy * sin, dy * cos - dx * sin], axis=1)


@pytest.mark.parametrize("turned_deg", [2.0, -2.0, 1.6, -3.3, 5.0, -7.0])
def test_lidar_alignment_turned_lidar_is_detected_with_angle(turned_deg: float) -> None:
    """A turned LiDAR is detected within some tens of meters, and its angle is reported."""
    drive = Drive(street(), turned_deg=lambda _: turned_deg).go()
    assert drive.noticed_m is not None and drive.noticed_m < 55.0
    assert drive.told_deg == pytest.approx(turned_deg, abs=0.25)


@pytest.mark.integration
@pytest.mark.parametrize("seed", range(4))
def test_a_healthy_lidar_is_not_accused(seed: int) -> None:
    drive = Drive(street(seed), seed=seed).go(200.0)
    assert drive.noticed_m is None
    assert len(drive.matches) > 15
    assert max(map(abs, drive.matches)) < HEALTHY_DEG


@pytest.mark.integration
@pytest.mark.parametrize("turned_deg", [0.5, -0.8])
def test_lidar_alignment_mounting_tolerance_and_crosswind_are_no_fault(turned_deg: float) -> None:
    assert Drive(street(), turned_deg=lambda _: turned_deg).go(200.0).noticed_m is None


@pytest.mark.integration
def test_lidar_alignment_mount_that_fails_while_driving_is_detected() -> None:
    """A mount that gives way on the road is detected soon."""
    drive = Drive(street(), turned_deg=lambda driven: 2.0 if driven > 80.0 else 0.0).go(200.0)
    assert drive.noticed_m is not None and 80.0 < drive.noticed_m < 130.0


@pytest.mark.integration
@pytest.mark.parametrize("turned_deg", [0.0, 2.0, -2.5])
def test_lidar_alignment_in_bend_detects_only_turned_lidar(turned_deg: float) -> None:
    """In a bend a turned LiDAR is detected as well, and no other is."""
    # 60 m of radius at 7 m/s: 0.8 m/s2
    drive = Drive(ring(), lambda _: 7.0, lambda _: 7.0 / 60.0, lambda _: turned_deg).go(150.0)
    assert len(drive.matches) >= 5
    if turned_deg == 0.0:
        assert drive.noticed_m is None and max(map(abs, drive.matches)) < HEALTHY_DEG
    else:
        assert drive.told_deg == pytest.approx(turned_deg, abs=0.35)


@pytest.mark.integration
def test_lidar_alignment_slip_in_tight_bend_is_no_fault() -> None:
    """A body that slips in a tight bend is not a turned LiDAR."""
    # 12 m of radius at 6.5 m/s, round and round: 3.5 m/s2, and the body slips by 2 degrees all the time.
    drive = Drive(ring(12.0), lambda _: 6.5, lambda _: 6.5 / 12.0, slip_per_mps2=math.radians(0.57)).go(200.0)
    assert drive.noticed_m is None


@pytest.mark.integration
@pytest.mark.parametrize("radius_m", [9.0, 20.0, 34.0])
def test_lidar_alignment_other_wheelbase_in_circle_is_no_fault(radius_m: float) -> None:
    """A vehicle with another wheelbase in a slow circle is not reported."""
    drive = Drive(ring(radius_m), lambda _: 3.0, lambda _: 3.0 / radius_m, rear_axle_m=REAR_AXLE_M + 0.5).go(120.0)
    assert drive.noticed_m is None


@pytest.mark.integration
@pytest.mark.parametrize("turned_deg", [0.0, -2.0])
def test_a_gyro_that_is_off_neither_accuses_nor_hides(turned_deg: float) -> None:
    drive = Drive(
        street(), lambda _: 5.0, turned_deg=lambda _: turned_deg, gyro_offset_rps=0.01, gyro_noise_rps=0.01
    ).go()
    if turned_deg == 0.0:
        assert drive.noticed_m is None
    else:
        assert drive.told_deg == pytest.approx(turned_deg, abs=0.4)


@pytest.mark.integration
@pytest.mark.parametrize("turned_deg", [0.0, 2.0])
def test_backing_up_counts_as_well(turned_deg: float) -> None:
    drive = Drive(street(), lambda _: -2.0, turned_deg=lambda _: turned_deg).go(55.0)
    assert (drive.noticed_m is not None) == (turned_deg != 0.0)
    if turned_deg:
        assert drive.told_deg == pytest.approx(turned_deg, abs=0.3)


@pytest.mark.integration
@pytest.mark.parametrize("turned_deg", [0.0, 5.0])
def test_where_nothing_stands_upright_nothing_is_said(turned_deg: float) -> None:
    drive = Drive(np.zeros((0, 2)), turned_deg=lambda _: turned_deg).go(200.0)
    assert drive.matches == []
    assert drive.noticed_m is None


def convoy(t: float) -> Floats:
    """(n, 2): sides of eight lorries around the ego that drift to its left, by 3 % of the way that all of them go."""
    return np.concatenate([corners_of(box) for box in lorries(t)])


def lorries(t: float) -> Floats:
    """(8, 5): their footprints: x, y, yaw, length, width."""
    at = [(8.0 * t + along, aside + 0.24 * t) for along in (-26.0, -9.0, 12.0, 30.0) for aside in (-9.0, 9.0)]
    return np.array([(x, y, 0.0, 12.0, 2.5) for x, y in at])


def corners_of(box: Floats) -> Floats:
    x, y, _, length, width = box
    half = length / 2.0, width / 2.0
    four = [
        (x - half[0], y - half[1]),
        (x + half[0], y - half[1]),
        (x + half[0], y + half[1]),
        (x - half[0], y + half[1]),
    ]
    return np.concatenate([line(four[i - 1], four[i]) for i in range(4)])


@pytest.mark.integration
def test_lidar_alignment_known_moving_trucks_are_not_measured() -> None:
    """A column of trucks that are known to move is not used as a measurement."""
    drive = Drive(np.zeros((0, 2)), others=convoy, others_known=lorries).go(160.0)
    assert drive.matches == []


@pytest.mark.integration
@pytest.mark.parametrize("turned_deg", [0.0, 2.0])
@pytest.mark.parametrize("known", [True, False])
def test_lorries_in_a_street_neither_accuse_nor_hide(turned_deg: float, known: bool) -> None:
    drive = Drive(
        street(1),
        turned_deg=lambda _: turned_deg,
        others=lambda t: convoy(t % 12.0),
        others_known=(lambda t: lorries(t % 12.0)) if known else (lambda _: NOBODY),
    ).go(90.0)
    assert (drive.noticed_m is not None) == (turned_deg != 0.0)


def test_a_vehicle_that_stands_measures_nothing() -> None:
    drive = Drive(street(), lambda _: 0.0, turned_deg=lambda _: 2.0).go(most_s=15.0)
    assert drive.matches == []


def test_a_vehicle_that_was_hit_does_not_accuse_its_lidar() -> None:
    def pushed(t: float) -> float:
        """Every second something hits it from behind, and it brakes again."""
        return 10.0 if t % 1.0 < 0.5 else 4.0

    drive = Drive(street(), pushed, turned_deg=lambda _: 2.0).go(100.0)
    assert drive.matches == []


def test_a_pause_of_the_lidar_ends_the_comparison() -> None:
    drive = Drive(street()).go(20.0)
    before = len(drive.matches)
    assert before
    alignment = drive.alignment
    later = PoseEstimate(10.0, 0.0, 0.0, 0.0, 0.0, 8.0, 0.0, np.eye(4))
    alignment.add(drive._sweep(np.random.default_rng(0), 10.0, (80.0, 0.0, 0.0), 0.0), later)
    assert alignment.look(NOBODY) is None
