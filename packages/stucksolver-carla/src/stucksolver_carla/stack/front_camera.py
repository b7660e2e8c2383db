"""The front camera, as in Bao and Li 2025: an occasional image, encoded only when a scene needs it."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING, Any, Protocol

from stucksolver.scene import CameraImage

if TYPE_CHECKING:
    import carla

WIDTH = 800
HEIGHT = 450
FOV_DEG = 90.0
PERIOD_S = 0.5
"""An image costs a simulator more than a tick, and a standing vehicle sees little new."""
QUALITY = 80


class PictureSource(Protocol):
    """Gives the front camera's latest image."""

    def image(self) -> CameraImage | None:
        """Return the latest image; None before the first."""

    def close(self) -> None:
        """Destroy the sensor."""


class FrontCamera:
    """Attach to a vehicle, call `image` whenever one is wanted, and `close` at the end.

    `front_m` is the distance ahead of the vehicle's center (m), inside the windscreen of most cars.
    """

    def __init__(
        self, vehicle: carla.Vehicle, front_m: float = 0.7, height_m: float = 1.6, period_s: float = PERIOD_S
    ) -> None:
        import carla

        blueprint = vehicle.get_world().get_blueprint_library().find("sensor.camera.rgb")
        for name, value in (
            ("image_size_x", WIDTH),
            ("image_size_y", HEIGHT),
            ("fov", FOV_DEG),
            ("sensor_tick", period_s),
        ):
            blueprint.set_attribute(name, str(value))
        place = carla.Transform(carla.Location(x=front_m, z=height_m))
        self._sensor = vehicle.get_world().spawn_actor(blueprint, place, attach_to=vehicle)
        self._raw: Any | None = None
        self._made: tuple[int, CameraImage] | None = None
        self._sensor.listen(self._take)

    def _take(self, image: Any) -> None:
        self._raw = image

    def image(self) -> CameraImage | None:
        """Return the latest image; None before the first."""
        raw = self._raw
        if raw is None:
            return None
        if self._made is None or self._made[0] != raw.frame:
            self._made = (raw.frame, _encoded(raw))
        return self._made[1]

    def close(self) -> None:
        """Destroy the sensor. The simulator may be gone already."""
        self._sensor.stop()
        self._sensor.destroy()


def _encoded(raw: Any) -> CameraImage:
    """Return a BGRA image as JPEG."""
    from PIL import Image

    return as_jpeg(Image.frombuffer("RGB", (raw.width, raw.height), bytes(raw.raw_data), "raw", "BGRX", 0, 1))


def as_jpeg(picture: Any) -> CameraImage:
    """Return a `PIL.Image` in the form of a scene."""
    file = io.BytesIO()
    picture.save(file, "JPEG", quality=QUALITY)
    return CameraImage(width=picture.width, height=picture.height, jpeg=base64.b64encode(file.getvalue()))
