"""Drives BehaviorAgent with StuckSolver in `leaderboard_evaluator.py --agent THIS_FILE --agent-config CONFIG.json`.

The built-in planner drives in place of BehaviorAgent if the configuration sets `driver` to `planner`.

This module runs in the evaluator's Python (3.8 with CARLA 0.9.15, or later); the solver runs in a separate process.
CARLA's `agents` package, the leaderboard and scenario_runner must be on the path; the evaluator itself requires that
too.

Perception is `privileged` by default: BehaviorAgent reads the world's actors. If the configuration sets `perception` to
`sensors`, the evaluator's sensor data go to the solver's process, where the built-in planner uses them to drive.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

import carla

# The evaluator puts this file's folder on the path and imports it by its bare name.
_PACKAGES = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
if _PACKAGES not in sys.path:
    sys.path.append(_PACKAGES)

from agents.navigation.behavior_agent import BehaviorAgent  # noqa: E402
from leaderboard.autoagents.autonomous_agent import AutonomousAgent, Track  # noqa: E402
from srunner.scenariomanager.carla_data_provider import CarlaDataProvider  # noqa: E402

from stucksolver_bridge.agent_driver import AgentDriver  # noqa: E402
from stucksolver_bridge.agent_plan import make_agent  # noqa: E402
from stucksolver_bridge.entry_config import NONE, PLANNER, SENSORS, TIMERS, Config, read_config  # noqa: E402
from stucksolver_bridge.guidance_script import GuidancePlayer  # noqa: E402
from stucksolver_bridge.in_process_planner import InProcessPlanner  # noqa: E402
from stucksolver_bridge.recovery_client import RecoveryClient  # noqa: E402
from stucksolver_bridge.sensor_client import SensorClient  # noqa: E402
from stucksolver_bridge.timer_baseline import TimerBaseline  # noqa: E402

CAMERA = {"x": 0.8, "y": 0.0, "z": 1.6, "roll": 0.0, "pitch": 0.0, "yaw": 0.0, "width": 1600, "height": 900, "fov": 70}
REAR = {"x": -2.0, "y": 0.0, "z": 1.6, "roll": 0.0, "pitch": 0.0, "yaw": 180.0, "width": 800, "height": 450, "fov": 70}
LIDAR = {"x": 0.0, "y": 0.0, "z": 2.5, "roll": 0.0, "pitch": 0.0, "yaw": -90.0}
AT_CENTER = {"x": 0.0, "y": 0.0, "z": 0.0, "roll": 0.0, "pitch": 0.0, "yaw": 0.0}


def get_entry_point() -> str:
    """Return the name of the class below; the evaluator calls this."""
    return "StuckSolverAgent"


class StuckSolverAgent(AutonomousAgent):  # type: ignore[misc]
    """The agent; the evaluator creates a new one for each route."""

    def setup(self, path_to_conf_file: str) -> None:
        """Read the configuration. Raises `ConfigError`, `PlannerError` or `SolverError`; the setup then fails."""
        self.track = Track.SENSORS
        self._config, self._name = read_config(path_to_conf_file)
        self._metrics: dict[str, Any] = {}
        self._driver: Any = None
        self._recovery: RecoveryClient | TimerBaseline | None = None
        self._sensor_client: SensorClient | None = None
        self._guidance: GuidancePlayer | None = None
        self._tick = 0
        self._place_m = 0.0
        self._write_event(dict(self._config._asdict()))
        # Bench2Drive sets the plan before this call, the leaderboard after it.
        if getattr(self, "_dense_plan", None) is not None:
            self._start(self._config)

    def set_global_plan(self, global_plan_gps: Any, global_plan_world_coord: Any) -> None:
        """Store the dense route in addition to the sparse one that the base class makes from it."""
        super().set_global_plan(global_plan_gps, global_plan_world_coord)
        self._dense_plan = global_plan_world_coord
        if getattr(self, "_config", None) is not None and self._driver is None and self._sensor_client is None:
            self._start(self._config)

    def sensors(self) -> list[dict[str, Any]]:
        """Return front camera, LiDAR, IMU, GNSS and speedometer, as in Bao and Li 2025 (arXiv:2510.26023).

        A rear camera is added, to detect emergency vehicles that approach from behind.
        """
        if not self._config.sensors:
            return [{"type": "sensor.speedometer", "reading_frequency": 20, "id": "SPEED"}]
        return [
            {"type": "sensor.camera.rgb", "id": "CAM_FRONT", **CAMERA},
            {"type": "sensor.camera.rgb", "id": "CAM_BACK", **REAR},
            {"type": "sensor.lidar.ray_cast", "id": "LIDAR", **LIDAR},
            {"type": "sensor.other.imu", "sensor_tick": 0.05, "id": "IMU", **AT_CENTER},
            {"type": "sensor.other.gnss", "sensor_tick": 0.01, "id": "GPS", **AT_CENTER},
            {"type": "sensor.speedometer", "reading_frequency": 20, "id": "SPEED"},
        ]

    def run_step(self, input_data: Any, timestamp: float) -> Any:
        """Return this tick's `carla.VehicleControl`."""
        self._send_utterances(timestamp)
        if self._sensor_client is not None:
            control = self._sensor_client.run_step(input_data)
        else:
            control = self._driver.run_step() if self._recovery is None else self._recovery.run_step()
        self._metrics[str(self._tick)] = self.get_metric_info()
        self._tick += 1
        return control

    def destroy(self) -> None:
        """End the solver's process, and write the file that Bench2Drive's tools read."""
        recovery = getattr(self, "_sensed", None) or getattr(self, "_recovery", None)
        self._recovery = self._sensor_client = None
        if recovery is not None:
            if recovery.fault is not None:
                self._write_event({"kind": "solver_gone", "text": recovery.fault})
            recovery.close()
        if getattr(self, "_metrics", None):
            self._write_metrics()
            self._metrics = {}

    # ---- parts

    def _start(self, config: Config) -> None:
        hero, carla_map = self.hero_actor, CarlaDataProvider.get_map()
        if config.perception == SENSORS:
            self._start_sensor_mode(config, hero, carla_map)
            return
        if config.driver == PLANNER:
            self._driver = InProcessPlanner(hero, config.behavior, carla_map)
        else:
            agent = make_agent(BehaviorAgent, hero, config.behavior, carla_map)
            # The agent must not stop at the end of its plan, because the evaluator ends the route.
            self._driver = AgentDriver(agent, carla, config.obstacles, keeps_going=True)
        plan = [(carla_map.get_waypoint(transform.location), option) for transform, option in self._dense_plan]
        self._driver.set_plan(plan)
        if config.recovery == NONE:
            return
        if config.recovery == TIMERS:
            self._recovery = TimerBaseline(self._driver, self._write_event)
            return
        self._recovery = RecoveryClient(
            self._driver,
            carla_map,
            carla,
            self._settings(config),
            config.python,
            config.path or None,
            self._write_event,
            answer_limit_s=config.answer_limit_s,
        )
        self._start_guidance(config)

    def _start_sensor_mode(self, config: Config, hero: Any, carla_map: Any) -> None:
        settings = {**self._settings(config), "driver": config.driver, "behavior": config.behavior}
        if config.rig:
            settings["rig"] = os.path.abspath(config.rig)
        self._sensor_client = SensorClient(
            hero,
            carla_map,
            carla,
            settings,
            self.sensors(),
            [(carla_map.get_waypoint(transform.location), option) for transform, option in self._dense_plan],
            config.python,
            config.path or None,
            self._write_event,
            answer_limit_s=config.answer_limit_s,
        )
        self._start_guidance(config)

    def _settings(self, config: Config) -> dict[str, Any]:
        """Return the settings for the solver's process."""
        settings = {"recovery": config.recovery, "reasoner": config.reasoner, "clock": config.clock}
        settings["ladder"] = config.ladder
        if config.record:
            settings["record"] = os.path.join(config.record, self._name)
        return settings

    def _start_guidance(self, config: Config) -> None:
        if config.guidance:
            # The name is RouteScenario_2101_rep0_Town10HD_...: its second part is the route's id.
            self._guidance = GuidancePlayer(config.guidance, self._name.split("_")[1])

    def _send_utterances(self, time_s: float) -> None:
        listener = self._sensor_client or self._recovery
        if self._guidance is None or listener is None:
            return
        velocity = self.hero_actor.get_velocity()
        speed = (velocity.x**2 + velocity.y**2) ** 0.5
        self._place_m += 0.05 * speed
        for utterance in self._guidance.due(time_s, self._place_m, speed):
            self._write_event({"kind": "passenger", "text": utterance, "time_s": time_s})
            listener.say(utterance)

    def _write_event(self, event: dict[str, Any]) -> None:
        """Append an event to the file at once, so that an interrupted run keeps its events."""
        if not self._config.events:
            return
        os.makedirs(self._config.events, exist_ok=True)
        with open(os.path.join(self._config.events, self._name + ".jsonl"), "a", encoding="utf-8") as file:
            file.write(json.dumps(event) + "\n")

    def _write_metrics(self) -> None:
        metrics = self._config.metrics or os.environ.get("SAVE_PATH", "")
        if metrics:
            folder = os.path.join(metrics, self._name)
            os.makedirs(folder, exist_ok=True)
            with open(os.path.join(folder, "metric_info.json"), "w", encoding="utf-8") as file:
                json.dump(self._metrics, file)
