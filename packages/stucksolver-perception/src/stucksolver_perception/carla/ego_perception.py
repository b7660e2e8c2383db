"""The eyes of one ego: sensors read on every tick, perception beside the loop, and its newest result with its age.

In a world that waits for us (`paced`) a result is used exactly `DELAY_S` after its data, however long it took, so that
a drive can be repeated. Otherwise it is used when it is ready. If perception falls behind, its results are older,
`lagging` says so, and the guard sees the age.
"""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import carla
import numpy as np

from stucksolver.scene import CameraImage, ObservedSign
from stucksolver.scene.surroundings import LightState
from stucksolver_carla.perception_interface import SensorError
from stucksolver_carla.stack.front_camera import HEIGHT, WIDTH, as_jpeg
from stucksolver_perception.camera.lens_dirt import LensMonitor
from stucksolver_perception.carla.known_posts import sign_places
from stucksolver_perception.carla.lane_sight import SensorLaneSight
from stucksolver_perception.carla.perceived_ego import PerceivedEgo
from stucksolver_perception.carla.perceived_objects import PerceivedBoxes, PerceivedTracker, actor_proxies, lamps_of
from stucksolver_perception.carla.perceived_world import PerceivedWorld
from stucksolver_perception.carla.sensor_faults import SensorFault
from stucksolver_perception.carla.sensor_suite import MeasurementSource, SensorSuite, TickMeasurements
from stucksolver_perception.carla.sign_worker import SignWorker, make_sign_reader
from stucksolver_perception.cycle_data import PerceptionInput, PerceptionResult
from stucksolver_perception.localization import EkfLocalizer
from stucksolver_perception.measurements import CameraFrame, Floats, LidarSweep, PoseEstimate
from stucksolver_perception.pipeline import LIGHT_REACH_M, PerceptionPipeline
from stucksolver_perception.rig import Rig, load_rig
from stucksolver_perception.sensor_health import SensorHealth

if TYPE_CHECKING:
    from stucksolver.scene.frenet import RoadFrame
PERIOD_S = 0.1
"""Ten results a second: one per turn of the LiDAR."""
DELAY_S = 0.1
"""From data to result in a world that waits: the time of perception on two cores, and a tick."""
LAGS_S = 0.3
"""Older results mean that perception has fallen behind."""
SEARCH_ABOVE_M = 0.5
"""The road's height is searched from a little above the last one, so that a bridge is not taken for the road."""
MOVES_MPS = 0.5
"""Below this speed a camera without noise may show the same image twice."""
BLIND_S = 0.6
"""A vehicle that has seen nothing for this long brakes: a little more than the age that the guard accepts."""
DARK_AGE_S = 60.0
"""The age of data that never came."""
TICK_S = 1e-6
REAR = "rear camera"


class EgoPerception:
    """Perceives the world for one ego. Call `tick` once after each tick of the world; give `vehicle` to drivers and
    stacks.

    There is a pose after the first tick; wait some more ticks before anybody drives, so that it is good. `tick` raises
    `SensorError` as well. `source` provides the measurements instead of sensors attached here; it is closed with the
    eyes.

    Raises:
        SensorError: A sensor is missing or gives no data.
        WeightsError: A network cannot be used.
    """

    pose: PoseEstimate
    """The ego's estimated pose on this tick."""

    perception = "sensors"

    def __init__(
        self,
        vehicle: carla.Vehicle,
        carla_map: carla.Map,
        rig: Rig | None = None,
        *,
        paced: bool = True,
        threads: int = 1,
        seed: int = 0,
        fault: SensorFault | None = None,
        source: MeasurementSource | None = None,
    ) -> None:
        self._rig = rig or load_rig()
        self._perceiver = PerceptionPipeline(self._rig, threads)
        self._localiser = EkfLocalizer(self._rig)
        self._suite = source or SensorSuite(vehicle, carla_map, self._rig, waits=paced, seed=seed)
        self._paced = paced
        self._map = carla_map
        self._height_m = float(vehicle.get_location().z)
        """Height of the road (m), known from the start like the route."""
        self._hero = vehicle
        self._heads = _heads(vehicle.get_world())
        self._worker = ThreadPoolExecutor(1, "perception")
        self._signs = SignWorker(self._rig.camera, make_sign_reader(), sign_places(carla_map), paced=paced)
        self._sweeps: list[tuple[LidarSweep, PoseEstimate]] = []
        self._picture: tuple[CameraFrame, PoseEstimate] | None = None
        self._rear: tuple[CameraFrame, PoseEstimate] | None = None
        self._under_way: deque[tuple[float, Future[PerceptionResult]]] = deque()
        self._begun_s = -np.inf
        self._why_blind: tuple[str, ...] = ()
        self._lags = False
        self.picture: CameraFrame | None = None
        """The camera's latest image; None before the first."""
        self.percept: PerceptionResult | None = None
        """The newest result; None before the first."""
        self.now_s = 0.0
        cameras = {"camera": self._rig.camera, REAR: self._rig.rear_camera}
        lenses = {name: LensMonitor(camera) for name, camera in cameras.items() if camera is not None}
        self.health = SensorHealth(self._rig.lidar, lenses=lenses)
        self._fault = fault
        self._began_s = float(vehicle.get_world().get_snapshot().timestamp.elapsed_seconds)
        self.vehicle = PerceivedEgo(vehicle, self, PerceivedWorld(vehicle.get_world(), carla_map, self))

    # ---- each tick

    def tick(self) -> None:
        """Read this tick's measurements, start a cycle of perception if one is due, and take a finished one.

        Raises:
            SensorError: A sensor gives no data.
        """
        measured = self._suite.read()
        self.now_s = float(self._hero.get_world().get_snapshot().timestamp.elapsed_seconds)
        if self._fault is not None:
            measured = self._fault.after(measured, self.now_s - self._began_s)
        self._locate(measured)
        self._take_in(measured)
        if self.now_s - self._begun_s >= PERIOD_S - TICK_S and self._sweeps and (self._paced or not self._under_way):
            self._begin()
        self._take_up()
        tracks = () if self.percept is None else self.percept.tracks
        self._signs.tick(self.now_s, self.pose, self.picture, tracks)
        self._say_lag()

    def close(self) -> None:
        """End the drive."""
        self._suite.close()
        self._worker.shutdown(wait=True, cancel_futures=True)
        self._signs.close()

    def _locate(self, measured: TickMeasurements) -> None:
        if measured.imu is not None:
            self._localiser.imu(measured.imu)
        self._localiser.wheel(measured.wheels)
        if measured.fix is not None:
            self._localiser.gnss(measured.fix)
        self.health.fixes(self._localiser.doubts_fixes)
        if not self._localiser.ready:
            raise SensorError("IMU and GNSS gave no data on the first tick, so the vehicle's position is unknown")
        pose = self._localiser.estimate(self.now_s)
        self._height_m = self._road_height_m(pose.x_m, pose.y_m)
        self.pose = replace(pose, z_m=self._height_m)

    def _road_height_m(self, x_m: float, y_m: float) -> float:
        """Return the height from the map (m): satellites measure heights poorly, and a vehicle is on its road."""
        waypoint = self._map.get_waypoint(carla.Location(x_m, -y_m, self._height_m + SEARCH_ABOVE_M))
        return self._height_m if waypoint is None else float(waypoint.transform.location.z)

    def _take_in(self, measured: TickMeasurements) -> None:
        sweep = self.health.sweep(measured.sweep)
        if sweep is not None:
            self._sweeps.append((sweep, self.pose))
        moves = abs(self.pose.speed_mps) > MOVES_MPS
        picture = measured.picture and self.health.picture(measured.picture, moves, pose=self.pose)
        if picture is not None:
            self._picture, self.picture = (picture, self.pose), picture
        rear = measured.rear and self.health.picture(measured.rear, moves, REAR, self.pose)
        if rear is not None:
            self._rear = rear, self.pose

    def _begin(self) -> None:
        picture, self._picture = self._picture, None
        rear, self._rear = self._rear, None
        look = PerceptionInput(
            pose=self.pose,
            sweeps=tuple(self._sweeps),
            picture=None if picture is None else picture[0],
            picture_pose=None if picture is None else picture[1],
            heads=self._near_heads(),
            rear=rear,
        )
        self._sweeps = []
        self._begun_s = self.now_s
        self._under_way.append((self.now_s, self._worker.submit(self._perceiver.perceive, look)))

    def _take_up(self) -> None:
        while self._under_way:
            since_s, future = self._under_way[0]
            due = self.now_s - since_s >= DELAY_S - TICK_S if self._paced else future.done()
            if not due:
                return
            self._under_way.popleft()
            self.percept = future.result()
            self.health.turned("LiDAR", self.percept.lidar_turned_rad)
            self.health.turned("camera", self.percept.camera_turned_rad)

    def _say_lag(self) -> None:
        lags = not self._paced and self.percept is not None and self.age_s(self.now_s) > LAGS_S
        if lags and not self._lags:
            print(
                f"stucksolver: perception has fallen behind: its last result is {self.age_s(self.now_s):.2f} s old; "
                "give it more cores, or a smaller rig",
                file=sys.stderr,
                flush=True,
            )
        self._lags = lags

    def _near_heads(self) -> dict[int, Floats]:
        """Return the lights within reach of the camera."""
        x, y = self.pose.x_m, self.pose.y_m
        away = {light: np.hypot(boxes[:, 0] - x, boxes[:, 1] - y).min() for light, boxes in self._heads.items()}
        return {light: self._heads[light] for light, gap_m in away.items() if gap_m < LIGHT_REACH_M}

    # ---- called by the stack

    def age_s(self, now_s: float) -> float:
        """Age of the newest result's data (s)."""
        return DARK_AGE_S if self.percept is None else now_s - self.percept.pose.time_s

    @property
    def blind(self) -> bool:
        """True if the newest result is too old to drive by."""
        return self.age_s(self.now_s) > BLIND_S

    @property
    def why_blind(self) -> tuple[str, ...]:
        """Return why nothing new is seen, as it was when that began; empty while the ego sees."""
        if not self.blind:
            self._why_blind = ()
        elif not self._why_blind:
            # Kept: the number of points that a failing LiDAR gives differs from sweep to sweep.
            self._why_blind = self.health.faults
        return self._why_blind

    def checked(self, control: carla.VehicleControl) -> carla.VehicleControl:
        """Return the control to apply: full braking with the wheels unchanged if the ego is blind."""
        if not self.blind:
            return control
        return carla.VehicleControl(steer=control.steer, brake=1.0, reverse=control.reverse)

    @property
    def position_sd_m(self) -> float:
        """Standard deviation of the ego's position in the worst direction (m)."""
        return float(np.sqrt(np.linalg.eigvalsh(self.pose.covariance[:2, :2])[-1]))

    @property
    def lagging(self) -> bool:
        """True if perception has fallen behind."""
        return self._lags

    @property
    def signs(self) -> tuple[ObservedSign, ...]:
        """Words that were read on signs while the ego has been standing; see `SignWorker`."""
        return self._signs.signs

    def light(self, light_id: int) -> LightState:
        """Return what a light on the map last showed; unknown if nothing certain was seen."""
        if self.percept is None:
            return LightState.UNKNOWN
        return self.percept.lights.get(light_id, LightState.UNKNOWN)

    def within(self, range_m: float) -> PerceivedBoxes:
        """Return the bodies for a driver; their range is that of the sensors."""
        return PerceivedBoxes(self, range_m)

    def tracker(self) -> PerceivedTracker:
        """Return the objects for the solver."""
        return PerceivedTracker(self)

    def camera(self) -> RigFrontCamera:
        """Return the front camera's image for scenes."""
        return RigFrontCamera(self)

    def sight_lines(self, frame: RoadFrame) -> SensorLaneSight:
        """Return how far lanes are seen on one road geometry."""
        return SensorLaneSight(self, frame)

    def actors(self, ids: Sequence[int]) -> list[Any]:
        """Return stand-ins for `carla.Actor`s: the kinds of the tracks with these ids."""
        return [] if self.percept is None else actor_proxies(self.percept, ids)

    def lamps(self) -> dict[int, int]:
        """Return the lamps of tracked vehicles, as bits of `carla.VehicleLightState`."""
        return {} if self.percept is None else lamps_of(self.percept)


def _heads(world: carla.World) -> Mapping[int, Floats]:
    """Boxes of the heads of all lights, by the light's id: (k, 7) center, half sizes and yaw in the local frame.

    They do not move and are known in advance, as in a high-definition map.
    """
    found: dict[int, Floats] = {}
    for light in world.get_actors().filter("*traffic_light*"):
        rows = []
        for box in light.get_light_boxes():
            at, half = box.location, box.extent
            rows.append((at.x, -at.y, at.z, half.x, half.y, half.z, -np.radians(box.rotation.yaw)))
        if rows:
            found[int(light.id)] = np.array(rows)
    return found


class RigFrontCamera:
    """See `GivesPicture`. The sensor belongs to the eyes."""

    def __init__(self, eyes: EgoPerception) -> None:
        self._eyes = eyes
        self._made: tuple[CameraFrame, CameraImage] | None = None

    def image(self) -> CameraImage | None:
        """Return the latest image; None before the first."""
        from PIL import Image

        frame = self._eyes.picture
        if frame is None:
            return None
        if self._made is None or self._made[0] is not frame:
            self._made = (frame, as_jpeg(Image.fromarray(frame.rgb).resize((WIDTH, HEIGHT), Image.Resampling.BOX)))
        return self._made[1]

    def close(self) -> None:
        """The eyes end their sensors themselves."""
