"""Perception of one ego: reads sensors on every tick, runs the pipeline in a thread.

In a world that waits (`paced`) a result is used exactly `DELAY_S` after its data, independent of the computing time, so
that a run can be repeated. Otherwise it is used when it is ready. If perception is too slow, its results are older,
`lagging` is True, and the guard checks the age.
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
from stucksolver_perception.carla.known_posts import sign_positions
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
"""Time between two results (s): one per turn of the LiDAR."""
DELAY_S = 0.1
"""Time from data to result in a world that waits (s): the computing time on two cores, and a tick."""
LAG_S = 0.3
"""Age of a result from which perception is too slow (s). Ours."""
SEARCH_ABOVE_M = 0.5
"""Height above the last road height from which the road is searched (m), so that a bridge above is skipped. Ours."""
MOVING_MPS = 0.5
"""Speed below which a camera without noise may give the same image twice (m/s). Ours."""
BLIND_S = 0.6
"""Age of a result from which the vehicle brakes (s): a little more than the age that the guard accepts."""
NO_DATA_AGE_S = 60.0
"""Age of the result before the first one (s). Ours."""
TICK_S = 1e-6
"""Tolerance of time comparisons (s): sums of ticks have rounding errors."""
REAR = "rear camera"
"""Name of the rear camera."""


class EgoPerception:
    """Perception of one ego. Call `tick` once after each tick of the world; pass `vehicle` to drivers and stacks.

    The first pose exists after the first tick. Wait some more ticks before the ego drives, so that the pose is
    accurate. `tick` raises `SensorError` as well. `source` replaces the sensors that are attached here; `close` closes
    it.

    Raises:
        SensorError: A sensor is missing or gives no data.
        NetworkFileError: A network cannot be used.
    """

    pose: PoseEstimate
    """The ego's estimated pose on this tick."""

    perception = "sensors"
    """Name of this source of perception."""

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
        self._pipeline = PerceptionPipeline(self._rig, threads)
        self._localizer = EkfLocalizer(self._rig)
        self._suite = source or SensorSuite(vehicle, carla_map, self._rig, waits=paced, seed=seed)
        self._paced = paced
        self._map = carla_map
        self._height_m = float(vehicle.get_location().z)
        """Height of the road (m). The first value is known, like the route."""
        self._ego_actor = vehicle
        self._heads = _heads(vehicle.get_world())
        self._worker = ThreadPoolExecutor(1, "perception")
        self._signs = SignWorker(self._rig.camera, make_sign_reader(), sign_positions(carla_map), paced=paced)
        self._sweeps: list[tuple[LidarSweep, PoseEstimate]] = []
        self._new_picture: tuple[CameraFrame, PoseEstimate] | None = None
        self._new_rear: tuple[CameraFrame, PoseEstimate] | None = None
        self._running: deque[tuple[float, Future[PerceptionResult]]] = deque()
        self._started_s = -np.inf
        self._why_blind: tuple[str, ...] = ()
        self._is_lagging = False
        self.picture: CameraFrame | None = None
        """The camera's latest image; None before the first."""
        self.percept: PerceptionResult | None = None
        """The newest result; None before the first."""
        self.now_s = 0.0
        cameras = {"camera": self._rig.camera, REAR: self._rig.rear_camera}
        lenses = {name: LensMonitor(camera) for name, camera in cameras.items() if camera is not None}
        self.health = SensorHealth(self._rig.lidar, lenses=lenses)
        self._fault = fault
        self._first_tick_s = float(vehicle.get_world().get_snapshot().timestamp.elapsed_seconds)
        self.vehicle = PerceivedEgo(vehicle, self, PerceivedWorld(vehicle.get_world(), carla_map, self))

    # ---- each tick

    def tick(self) -> None:
        """Read this tick's measurements, start a cycle of perception if one is due, and collect finished ones.

        Raises:
            SensorError: A sensor gives no data.
        """
        measured = self._suite.read()
        self.now_s = float(self._ego_actor.get_world().get_snapshot().timestamp.elapsed_seconds)
        if self._fault is not None:
            measured = self._fault.after(measured, self.now_s - self._first_tick_s)
        self._localize(measured)
        self._store(measured)
        if self.now_s - self._started_s >= PERIOD_S - TICK_S and self._sweeps and (self._paced or not self._running):
            self._start_cycle()
        self._collect_results()
        tracks = () if self.percept is None else self.percept.tracks
        self._signs.tick(self.now_s, self.pose, self.picture, tracks)
        self._report_lag()

    def close(self) -> None:
        """Close the sensors and end the threads."""
        self._suite.close()
        self._worker.shutdown(wait=True, cancel_futures=True)
        self._signs.close()

    def _localize(self, measured: TickMeasurements) -> None:
        if measured.imu is not None:
            self._localizer.imu(measured.imu)
        self._localizer.wheel(measured.wheels)
        if measured.fix is not None:
            self._localizer.gnss(measured.fix)
        self.health.fixes(self._localizer.doubts_fixes)
        if not self._localizer.ready:
            raise SensorError("IMU and GNSS gave no data on the first tick, so the vehicle's position is unknown")
        pose = self._localizer.estimate(self.now_s)
        self._height_m = self._road_height_m(pose.x_m, pose.y_m)
        self.pose = replace(pose, z_m=self._height_m)

    def _road_height_m(self, x_m: float, y_m: float) -> float:
        """Return the height from the map (m), because satellites measure heights poorly, and the ego is on its road."""
        waypoint = self._map.get_waypoint(carla.Location(x_m, -y_m, self._height_m + SEARCH_ABOVE_M))
        return self._height_m if waypoint is None else float(waypoint.transform.location.z)

    def _store(self, measured: TickMeasurements) -> None:
        sweep = self.health.sweep(measured.sweep)
        if sweep is not None:
            self._sweeps.append((sweep, self.pose))
        moves = abs(self.pose.speed_mps) > MOVING_MPS
        picture = measured.picture and self.health.picture(measured.picture, moves, pose=self.pose)
        if picture is not None:
            self._new_picture, self.picture = (picture, self.pose), picture
        rear = measured.rear and self.health.picture(measured.rear, moves, REAR, self.pose)
        if rear is not None:
            self._new_rear = rear, self.pose

    def _start_cycle(self) -> None:
        picture, self._new_picture = self._new_picture, None
        rear, self._new_rear = self._new_rear, None
        cycle_input = PerceptionInput(
            pose=self.pose,
            sweeps=tuple(self._sweeps),
            picture=None if picture is None else picture[0],
            picture_pose=None if picture is None else picture[1],
            heads=self._near_heads(),
            rear=rear,
        )
        self._sweeps = []
        self._started_s = self.now_s
        self._running.append((self.now_s, self._worker.submit(self._pipeline.perceive, cycle_input)))

    def _collect_results(self) -> None:
        while self._running:
            since_s, future = self._running[0]
            due = self.now_s - since_s >= DELAY_S - TICK_S if self._paced else future.done()
            if not due:
                return
            self._running.popleft()
            self.percept = future.result()
            self.health.turned("LiDAR", self.percept.lidar_turned_rad)
            self.health.turned("camera", self.percept.camera_turned_rad)

    def _report_lag(self) -> None:
        is_lagging = not self._paced and self.percept is not None and self.age_s(self.now_s) > LAG_S
        if is_lagging and not self._is_lagging:
            print(
                f"stucksolver: perception is too slow: its last result is {self.age_s(self.now_s):.2f} s old; "
                "use more cores, or a smaller rig",
                file=sys.stderr,
                flush=True,
            )
        self._is_lagging = is_lagging

    def _near_heads(self) -> dict[int, Floats]:
        """Return the heads of the lights within reach of the camera."""
        x, y = self.pose.x_m, self.pose.y_m
        distances = {light: np.hypot(boxes[:, 0] - x, boxes[:, 1] - y).min() for light, boxes in self._heads.items()}
        return {light: self._heads[light] for light, gap_m in distances.items() if gap_m < LIGHT_REACH_M}

    # ---- called by the stack

    def age_s(self, now_s: float) -> float:
        """Return the age of the newest result's data (s)."""
        return NO_DATA_AGE_S if self.percept is None else now_s - self.percept.pose.time_s

    @property
    def blind(self) -> bool:
        """True if the newest result is too old for driving."""
        return self.age_s(self.now_s) > BLIND_S

    @property
    def why_blind(self) -> tuple[str, ...]:
        """Sensor faults at the time when perception stopped giving results; empty while it gives them."""
        if not self.blind:
            self._why_blind = ()
        elif not self._why_blind:
            # The first text is stored, because the number of points of a failing LiDAR differs from sweep to sweep.
            self._why_blind = self.health.faults
        return self._why_blind

    def checked(self, control: carla.VehicleControl) -> carla.VehicleControl:
        """Return the control to apply: full braking with unchanged steering if the newest result is too old."""
        if not self.blind:
            return control
        return carla.VehicleControl(steer=control.steer, brake=1.0, reverse=control.reverse)

    @property
    def position_sd_m(self) -> float:
        """Standard deviation of the ego's position in the worst direction (m)."""
        return float(np.sqrt(np.linalg.eigvalsh(self.pose.covariance[:2, :2])[-1]))

    @property
    def lagging(self) -> bool:
        """True if perception is too slow."""
        return self._is_lagging

    @property
    def signs(self) -> tuple[ObservedSign, ...]:
        """Words read on signs since the ego stopped; see `SignWorker`."""
        return self._signs.signs

    def light(self, light_id: int) -> LightState:
        """Return the last state of a light on the map; unknown without a certain one."""
        if self.percept is None:
            return LightState.UNKNOWN
        return self.percept.lights.get(light_id, LightState.UNKNOWN)

    def within(self, range_m: float) -> PerceivedBoxes:
        """Return the source of objects for a driver. Their range is also limited by that of the sensors."""
        return PerceivedBoxes(self, range_m)

    def tracker(self) -> PerceivedTracker:
        """Return a tracker of the objects for the solver."""
        return PerceivedTracker(self)

    def camera(self) -> RigFrontCamera:
        """Return the source of the front camera's images for scenes."""
        return RigFrontCamera(self)

    def sight_lines(self, frame: RoadFrame) -> SensorLaneSight:
        """Return the source of sight distances on one road geometry."""
        return SensorLaneSight(self, frame)

    def actors(self, ids: Sequence[int]) -> list[Any]:
        """Return proxies of `carla.Actor`s with the kinds of the tracks with these ids."""
        return [] if self.percept is None else actor_proxies(self.percept, ids)

    def lamps(self) -> dict[int, int]:
        """Return the lamps of tracked vehicles, as bits of `carla.VehicleLightState`."""
        return {} if self.percept is None else lamps_of(self.percept)


def _heads(world: carla.World) -> Mapping[int, Floats]:
    """Return the boxes of all lights' heads, by the light's id: (k, 7) center, half sizes and yaw in the local frame.

    They are constant and known in advance, as in a high-definition map.
    """
    heads_by_light: dict[int, Floats] = {}
    for light in world.get_actors().filter("*traffic_light*"):
        rows = []
        for box in light.get_light_boxes():
            center, half = box.location, box.extent
            rows.append((center.x, -center.y, center.z, half.x, half.y, half.z, -np.radians(box.rotation.yaw)))
        if rows:
            heads_by_light[int(light.id)] = np.array(rows)
    return heads_by_light


class RigFrontCamera:
    """The rig's front camera as a `PictureSource`. The sensor belongs to the `EgoPerception`."""

    def __init__(self, perception: EgoPerception) -> None:
        self._perception = perception
        self._encoded_image: tuple[CameraFrame, CameraImage] | None = None

    def image(self) -> CameraImage | None:
        """Return the latest image; None before the first."""
        from PIL import Image

        frame = self._perception.picture
        if frame is None:
            return None
        if self._encoded_image is None or self._encoded_image[0] is not frame:
            self._encoded_image = (
                frame,
                as_jpeg(Image.fromarray(frame.rgb).resize((WIDTH, HEIGHT), Image.Resampling.BOX)),
            )
        return self._encoded_image[1]

    def close(self) -> None:
        """Do nothing, because the `EgoPerception` closes its sensors."""
