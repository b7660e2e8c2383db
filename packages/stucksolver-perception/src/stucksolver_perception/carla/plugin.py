"""Registers sensor-based perception of vehicles in CARLA as a plug-in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from stucksolver_carla.perception_interface import SensorError
from stucksolver_carla.remote_stack import RemoteStack, UnusableError
from stucksolver_perception.pipeline import missing_libraries

if TYPE_CHECKING:
    import carla

    from stucksolver_carla.session_settings import SessionSettings
    from stucksolver_perception.carla.ego_perception import EgoPerception


class SensorPerception:
    """The plug-in; see `stucksolver_carla.perception_interface.PerceptionPlugin`.

    Networks and their libraries are imported on first use, so that the plug-in loads without them.
    """

    def missing(self) -> str | None:
        """Return the missing packages with the remedy; None if all are installed."""
        return missing_libraries()

    def open(self, vehicle: carla.Vehicle, carla_map: carla.Map, *, paced: bool) -> EgoPerception:
        """Attach sensors to a vehicle. Raises `SensorError`."""
        from stucksolver_perception.carla.ego_perception import EgoPerception

        return EgoPerception(vehicle, carla_map, paced=paced)

    def remote_stack(
        self, opening: Mapping[str, Any], settings: SessionSettings, ask: Callable[[str], Any], *, uses_image: bool
    ) -> RemoteStack:
        """Return the stack of a vehicle that sends its measurements. Raises `UnusableError`."""
        from stucksolver_perception.carla.sidecar_perception import SidecarPerception
        from stucksolver_perception.network_files import NetworkFileError
        from stucksolver_perception.rig import RigError

        try:
            return SidecarPerception(opening, settings, ask, uses_image)
        except (RigError, NetworkFileError, SensorError) as error:
            raise UnusableError(f"perception 'sensors': {error}") from error


SENSORS = SensorPerception()
