"""Dirt on the lens is noticed while the vehicle drives, whatever it looks like; a clean lens is never accused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stucksolver_perception.camera.crops import CropWindows, behind_dirt
from stucksolver_perception.camera.horizon_strip import is_dirty
from stucksolver_perception.camera.lens_dirt import LensMonitor
from stucksolver_perception.measurements import CameraFrame, PoseEstimate
from stucksolver_perception.rig import CameraRig, SensorMount, load_rig
from stucksolver_perception.sensor_health import SensorHealth

SMALL = 4.0
"""The tests' images are smaller than those of the shipped rig by this factor."""
AHEAD = CameraRig(mount=SensorMount(x_m=0.8, y_m=0.0, z_m=1.6), width_px=400, height_px=225, fov_deg=70.0)
BACK = AHEAD.model_copy(update={"mount": SensorMount(x_m=-2.0, y_m=0.0, z_m=1.6, yaw_deg=180.0)})
TILE = np.random.default_rng(5).normal(0.0, 1.0, (512, 512))
HOUSES = np.random.default_rng(6).integers(0, 60, 720)
LOOKS_APART_M = 2.0


def pose_at(x_m=0.0, y_m=0.0, yaw_rad=0.0):
    return PoseEstimate(0.0, x_m, y_m, 0.0, yaw_rad, 10.0, 0.0, np.eye(4))


def scene(pose, rig=AHEAD, light=1.0):
    """A road with grainy asphalt, solid lines, dashes and kerbs, below a skyline with clouds: (height, width, 3)."""
    row, column = np.mgrid[0 : rig.height_px, 0 : rig.width_px] + 0.5
    looks = math.radians(rig.mount.yaw_deg)
    left, up = (rig.width_px / 2.0 - column) / rig.focal_px, (rig.height_px / 2.0 - row) / rig.focal_px
    far_m = rig.mount.z_m / np.maximum(-up, 1e-3)
    yaw = pose.yaw_rad + looks
    ahead_m, left_m = far_m, far_m * left
    x = pose.x_m + rig.mount.x_m * math.cos(pose.yaw_rad) + ahead_m * math.cos(yaw) - left_m * math.sin(yaw)
    y = pose.y_m + rig.mount.x_m * math.sin(pose.yaw_rad) + ahead_m * math.sin(yaw) + left_m * math.cos(yaw)
    grain = TILE[(x / 0.05).astype(int) % 512, (y / 0.05).astype(int) % 512]
    road = 80.0 + 6.0 * grain
    road += 120.0 * ((np.abs(np.abs(y) - 1.75) < 0.08) | (np.abs(y - 5.25) < 0.06) & (x % 12.0 < 4.0))
    road = np.where(np.abs(y) > 7.0, 140.0 + 20.0 * grain, road)
    bearing = np.degrees(yaw + np.arctan(left))
    skyline = HOUSES[(2.0 * bearing).astype(int) % 720] / AHEAD.height_px * (rig.height_px / 225.0)
    sky = 170.0 + 60.0 * up + 50.0 * (np.sin(np.radians(7.0 * bearing)) + np.sin(40.0 * up) > 1.4)
    sky = np.where(up < skyline, 60.0 + 1.5 * HOUSES[(2.0 * bearing).astype(int) % 720], sky)
    gray = np.clip(light * np.where(up < 0.0, road, sky), 0.0, 255.0).astype(np.uint8)
    return np.repeat(gray[:, :, None], 3, axis=2)


def straight(meters, start_m=0.0):
    """Poses on the way."""
    return [pose_at(x) for x in np.arange(start_m, start_m + meters, LOOKS_APART_M)]


def turning(degrees, each=120.0):
    """Poses around bends of `each` degrees, to the left and to the right in turn; the radius is 12 m."""
    step, x, y, yaw, left, poses = math.radians(4.0), 0.0, 0.0, 0.0, 1.0, []
    for k in range(round(degrees / 4.0)):
        poses.append(pose_at(x, y, yaw))
        x, y = x + 12.0 * step * math.cos(yaw), y + 12.0 * step * math.sin(yaw)
        left = -left if k % round(each / 4.0) == 0 else left
        yaw += left * step
    return poses


def grains(size_px, share, soft=False, rig=AHEAD, seed=0):
    """(height, width): how opaque the lens is, with grains of a size in pixels of the shipped camera."""
    side = max(round(size_px / SMALL), 1)
    chance = np.random.default_rng(seed)
    few = chance.random((rig.height_px // side + 1, rig.width_px // side + 1)) < share
    opaque = np.kron(few, np.ones((side, side)))[: rig.height_px, : rig.width_px]
    return smooth(opaque, max(side // 4, 1)) * 0.6 if soft else opaque


def smooth(opaque, by):
    """The same with soft rims."""
    for axis in (0, 1):
        opaque = np.mean([np.roll(opaque, k, axis) for k in range(-by, by + 1)], axis=0)
    return opaque


def disc(row, column, radius_px, rig=AHEAD, soft_px=2.0):
    y, x = np.mgrid[0 : rig.height_px, 0 : rig.width_px]
    return np.clip((radius_px - np.hypot(y - row, x - column)) / soft_px + 0.5, 0.0, 1.0)


def behind(rgb, opaque, gray):
    """The image through a lens with dirt of a brightness."""
    return (rgb * (1.0 - opaque[:, :, None]) + gray * opaque[:, :, None]).astype(np.uint8)


def drive(monitor, poses, opaque=None, gray=200, rig=AHEAD, light=1.0, own=None):
    """Drive, and return after how many images there was dirt for the first time."""
    first = None
    for k, pose in enumerate(poses):
        rgb = scene(pose, rig, light)
        rgb = rgb if own is None else own(rgb)
        monitor.watch(rgb if opaque is None else behind(rgb, opaque, gray), pose)
        if first is None and monitor.dirt is not None:
            first = k
    return first


@pytest.mark.integration
@pytest.mark.parametrize("light", [1.0, 0.12], ids=["day", "night"])
@pytest.mark.parametrize("rig", [AHEAD, BACK], ids=["front", "rear"])
def test_a_long_straight_road_with_solid_lines_is_no_dirt(rig, light):
    assert drive(LensMonitor(rig), straight(250.0), rig=rig, light=light) is None


@pytest.mark.integration
@pytest.mark.parametrize("rig", [AHEAD, BACK], ids=["front", "rear"])
def test_turns_below_clouds_and_houses_far_away_are_no_dirt(rig):
    assert drive(LensMonitor(rig), turning(720.0), rig=rig) is None


@pytest.mark.integration
def test_a_car_ahead_at_the_same_speed_is_no_dirt():
    def followed(rgb):
        rgb[95:150, 165:235] = 30  # its lower edge is 10 m away
        rgb[100:115, 175:225] = 180
        return rgb

    assert drive(LensMonitor(AHEAD), straight(250.0), own=followed) is None


@pytest.mark.integration
def test_a_car_ahead_all_around_a_roundabout_is_no_dirt():
    def followed(rgb):
        rgb[95:150, 80:150] = 30
        rgb[100:115, 95:135] = 180
        return rgb

    assert drive(LensMonitor(AHEAD), turning(720.0, 2000.0), own=followed) is None


@pytest.mark.integration
def test_lens_own_shadow_and_headlight_cone_are_no_dirt():
    def dark(rgb):
        rgb[205:, 100:300] //= 2
        return rgb

    below = np.clip((np.arange(225)[:, None] - 118.0) / 20.0, 0.0, 1.0)
    glow = 90.0 * below * np.exp(-((np.arange(400) - 200.0) ** 2) / 90.0**2)

    def lit(rgb):
        return np.minimum(rgb + glow[:, :, None], 255.0).astype(np.uint8)

    assert drive(LensMonitor(AHEAD), straight(200.0), own=dark) is None
    assert drive(LensMonitor(AHEAD), straight(200.0) + turning(480.0), light=0.12, own=lit) is None


@pytest.mark.integration
def test_a_bonnet_across_the_image_is_no_dirt():
    rim = 205.0 + 15.0 * ((np.arange(400) - 200.0) / 200.0) ** 2
    bonnet = np.arange(225)[:, None] > rim

    def own(rgb):
        rgb[bonnet] = 200
        return rgb

    assert drive(LensMonitor(AHEAD), straight(200.0) + turning(480.0), own=own) is None


@pytest.mark.parametrize("soft", [False, True], ids=["sharp", "soft"])
@pytest.mark.parametrize("gray", [200, 20], ids=["salt", "mud"])
@pytest.mark.parametrize(("size_px", "share"), [(6, 0.05), (12, 0.05), (24, 0.05), (40, 0.1)])
def test_grains_all_over_the_lens_are_noticed_within_40_m(size_px, share, gray, soft):
    monitor = LensMonitor(AHEAD)
    first = drive(monitor, straight(40.0), grains(size_px, share, soft), gray)
    assert first is not None
    assert first >= 10, "a few looks are not enough"
    assert monitor.dirt.is_too_much


@pytest.mark.integration
def test_lens_salt_is_detected_at_night_rear_and_in_reverse():
    """Salt is detected at night, by the rear camera and in reverse."""
    assert drive(LensMonitor(AHEAD), straight(40.0), grains(24, 0.05), light=0.12) is not None
    assert drive(LensMonitor(BACK), straight(40.0), grains(24, 0.05), rig=BACK) is not None
    assert drive(LensMonitor(AHEAD), straight(40.0)[::-1], grains(24, 0.05)) is not None


@pytest.mark.integration
def test_the_shipped_cameras_images_are_watched_as_well():
    rig = load_rig().camera
    opaque = np.kron(grains(24, 0.05), np.ones((4, 4)))
    assert drive(LensMonitor(rig), straight(40.0), opaque, rig=rig) is not None
    assert drive(LensMonitor(rig), straight(40.0), rig=rig) is None


@pytest.mark.integration
def test_lens_smear_in_one_place_is_detected_after_turns():
    """A smear in one place is detected when the vehicle has turned."""
    monitor, opaque = LensMonitor(AHEAD), disc(120, 250, 30, soft_px=10.0)
    assert drive(monitor, straight(200.0), opaque, gray=30) is None
    assert drive(monitor, turning(80.0, 80.0), opaque, gray=30) is None, "one turn may be a roundabout"
    assert drive(monitor, turning(240.0), opaque, gray=30) is not None
    assert 0.5 * opaque.mean() < monitor.dirt.share < 2.0 * opaque.mean()
    assert monitor.dirt.is_too_much


@pytest.mark.integration
def test_lens_spot_masks_only_crops_that_it_touches():
    """A spot is located, and only crops that it touches are not read."""
    monitor, opaque = LensMonitor(AHEAD), disc(60, 100, 8)
    drive(monitor, turning(240.0), opaque, gray=20)
    frame = CameraFrame(1.0, behind(scene(pose_at()), opaque, 20))
    seen, why = monitor.checked(frame, None, "camera")
    assert seen.rgb is frame.rgb
    assert why.startswith("dirt on the lens touches 0.")
    boxes = np.array([[95.0, 55.0, 105.0, 65.0], [200.0, 55.0, 260.0, 65.0], [60.0, 40.0, 140.0, 90.0]])
    windows = CropWindows(boxes, np.ones(3), np.ones(3, bool))
    assert behind_dirt(windows, seen).tolist() == [True, False, True]
    assert not behind_dirt(windows, frame).any()


def test_lens_spot_on_horizon_disables_far_view():
    """A spot on the horizon disables far detection."""
    rig = load_rig().camera
    cells = np.zeros((56, 100), bool)
    cells[10, 50] = True
    assert not is_dirty(CameraFrame(0.0, np.zeros((900, 1600, 3), np.uint8), cells), rig)
    cells[28, 50] = True
    assert is_dirty(CameraFrame(0.0, np.zeros((900, 1600, 3), np.uint8), cells), rig)


@pytest.mark.integration
def test_lens_cleaned_is_trusted_again_after_40_m():
    """A lens that was cleaned is trusted again after some tens of meters."""
    monitor = LensMonitor(AHEAD)
    drive(monitor, straight(60.0), grains(24, 0.05))
    assert monitor.dirt is not None
    drive(monitor, straight(10.0, 60.0))
    assert monitor.dirt is not None
    drive(monitor, straight(30.0, 70.0))
    assert monitor.dirt is None


@pytest.mark.integration
def test_lens_wiped_smear_is_dropped_in_next_turns():
    """A smear that was wiped away is dropped in the next turns."""
    monitor = LensMonitor(AHEAD)
    drive(monitor, turning(240.0), disc(120, 250, 30), gray=30)
    assert monitor.dirt is not None
    drive(monitor, turning(240.0))
    assert monitor.dirt is None


@pytest.mark.integration
def test_nothing_is_learned_while_the_vehicle_stands():
    salted = behind(scene(pose_at()), grains(24, 0.05), 200)
    monitor = LensMonitor(AHEAD)
    for _ in range(100):
        assert monitor.checked(CameraFrame(0.0, salted), None, "camera")[0] is not None
        monitor.watch(salted, pose_at())
    assert monitor.dirt is None
    drive(monitor, straight(60.0), grains(24, 0.05))
    for _ in range(100):
        assert monitor.checked(CameraFrame(0.0, scene(pose_at())), None, "camera")[0] is None


@pytest.mark.integration
def test_health_names_dirty_camera_and_rejects_its_images():
    """Health names the dirt of each camera and rejects the images of a dirty one."""
    health = SensorHealth(load_rig().lidar, lenses={"camera": LensMonitor(AHEAD), "rear camera": LensMonitor(BACK)})
    for pose in straight(60.0):
        front = CameraFrame(0.0, behind(scene(pose), grains(24, 0.05), 200))
        ahead = health.picture(front, moves=True, pose=pose)
        rear = health.picture(CameraFrame(0.0, scene(pose, BACK)), True, "rear camera", pose)
    assert ahead is None
    assert rear is not None
    assert len(health.faults) == 1
    assert health.faults[0].startswith("dirt on the lens touches ")
    assert health.faults[0].endswith("% of the camera's picture")
