"""The plug-in that gives vehicles in CARLA perception with their own sensors."""

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
    """See `stucksolver_carla.perception_interface.PerceptionPlugin`.

    Networks and their libraries are imported when they are used, so that the plug-in loads without them.
    """

    def missing(self) -> str | None:
        """Return what is not installed, with the remedy, or None."""
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
