"""Interface of perception with the vehicle's own sensors. `stucksolver-perception` implements it as a plug-in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

from stucksolver.plugins import plugins

if TYPE_CHECKING:
    import carla

    from stucksolver_carla.remote_stack import RemoteStack
    from stucksolver_carla.session_settings import SessionSettings


class SensorError(RuntimeError):
    """A sensor of the rig cannot be attached or gives no data. The message names it and the remedy."""


class EgoPerception(Protocol):
    """Perception of one vehicle. Call `tick` on every tick, before the vehicle is used."""

    perception: str
    """Name of this source of perception."""

    @property
    def vehicle(self) -> Any:
        """The vehicle as perceived; has the methods of `carla.Vehicle` that the stack uses."""

    def tick(self) -> None:
        """Read the sensors. Raises `SensorError`."""

    def checked(self, control: carla.VehicleControl) -> carla.VehicleControl:
        """Return the control, or a brake if nothing has been perceived for too long."""

    def close(self) -> None:
        """Remove the sensors."""


class PerceptionPlugin(Protocol):
    """What an entry point in `stucksolver.perception` loads."""

    def missing(self) -> str | None:
        """Return what is not installed, with the remedy, or None."""

    def open(self, vehicle: carla.Vehicle, carla_map: carla.Map, *, paced: bool) -> EgoPerception:
        """Attach sensors to a vehicle. `paced`: a simulated world waits for perception. Raises `SensorError`."""

    def remote_stack(
        self, opening: Mapping[str, Any], settings: SessionSettings, ask: Callable[[str], Any], *, uses_image: bool
    ) -> RemoteStack:
        """Return the stack of a vehicle in another process that sends its measurements.

        `uses_image`: a reasoner uses the camera's image. Raises `UnusableError`.
        """


def sensor_perception() -> PerceptionPlugin:
    """Return the installed perception.

    Raises:
        SensorError: None is installed, or a package that it needs is missing.
        PluginError: It cannot be loaded.
    """
    for plugin in plugins("perception"):
        found: PerceptionPlugin = plugin.load()
        missing = found.missing()
        if missing:
            raise SensorError(f"perception 'sensors': {missing}")
        return found
    raise SensorError("perception 'sensors' is not installed; add the extra [perception] (README, Install)")
