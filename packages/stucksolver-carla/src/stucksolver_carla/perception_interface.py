"""Defines the interface of sensor-based perception. `stucksolver-perception` implements it as a plug-in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

from stucksolver.plugins import plugins

if TYPE_CHECKING:
    import carla

    from stucksolver_carla.remote_stack import RemoteStack
    from stucksolver_carla.session_settings import SessionSettings


class SensorError(RuntimeError):
    """A sensor of the rig cannot be attached or gives no data. The message names the sensor and the remedy."""


class EgoPerception(Protocol):
    """Perception of one vehicle. Call `tick` on every tick, before the vehicle is used."""

    perception: str
    """Name of this source of perception."""

    @property
    def vehicle(self) -> Any:
        """The perceived vehicle, with the methods of `carla.Vehicle` that the stack uses."""

    def tick(self) -> None:
        """Read the sensors. Raises `SensorError`."""

    def checked(self, control: carla.VehicleControl) -> carla.VehicleControl:
        """Return the control, or a braking control if the newest result is too old."""

    def close(self) -> None:
        """Remove the sensors."""


class PerceptionPlugin(Protocol):
    """The object that an entry point in `stucksolver.perception` loads."""

    def missing(self) -> str | None:
        """Return the name of a missing package with the remedy; None if all are installed."""

    def open(self, vehicle: carla.Vehicle, carla_map: carla.Map, *, paced: bool) -> EgoPerception:
        """Attach sensors to a vehicle. `paced`: the simulated world waits for perception. Raises `SensorError`."""

    def remote_stack(
        self, opening: Mapping[str, Any], settings: SessionSettings, ask: Callable[[str], Any], *, uses_image: bool
    ) -> RemoteStack:
        """Return the stack of a vehicle in another process that sends its measurements.

        `uses_image`: a reasoner uses the camera's image. Raises `UnusableError`.
        """


def sensor_perception() -> PerceptionPlugin:
    """Return the installed perception plug-in.

    Raises:
        SensorError: No plug-in is installed, or it requires a package that is missing.
        PluginError: The plug-in cannot be loaded.
    """
    for plugin in plugins("perception"):
        perception: PerceptionPlugin = plugin.load()
        missing = perception.missing()
        if missing:
            raise SensorError(f"perception 'sensors': {missing}")
        return perception
    raise SensorError("perception 'sensors' is not installed; add the extra [perception] (README, Install)")
