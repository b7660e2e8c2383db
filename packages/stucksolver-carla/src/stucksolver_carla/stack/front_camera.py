"""Reads the front camera, as in Bao and Li 2025: few images, encoded only when a scene uses them."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING, Any, Protocol

from stucksolver.scene import CameraImage

if TYPE_CHECKING:
    import carla

WIDTH = 800
"""Image width (px). Ours."""
HEIGHT = 450
"""Image height (px). Ours."""
FOV_DEG = 90.0
"""Horizontal field of view (degrees): the default of CARLA's camera."""
PERIOD_S = 0.5
"""Time between two images (s). An image takes a simulator longer than a tick, and a stopped ego gets few new views."""
JPEG_QUALITY = 80
"""Quality setting of the JPEG encoder. Ours."""


class PictureSource(Protocol):
    """Source of the front camera's latest image."""

    def image(self) -> CameraImage | None:
        """Return the latest image; None before the first."""

    def close(self) -> None:
        """Destroy the sensor."""


class FrontCamera:
    """A front camera that is attached to a vehicle. Call `image` on demand, and `close` at the end.

    `front_m` is the distance ahead of the vehicle's center (m); the default is behind the windshield of most cars.
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
        mount = carla.Transform(carla.Location(x=front_m, z=height_m))
        self._sensor = vehicle.get_world().spawn_actor(blueprint, mount, attach_to=vehicle)
        self._raw: Any | None = None
        self._encoded_image: tuple[int, CameraImage] | None = None
        self._sensor.listen(self._store)

    def _store(self, image: Any) -> None:
        self._raw = image

    def image(self) -> CameraImage | None:
        """Return the latest image; None before the first."""
        raw = self._raw
        if raw is None:
            return None
        if self._encoded_image is None or self._encoded_image[0] != raw.frame:
            self._encoded_image = (raw.frame, _to_camera_image(raw))
        return self._encoded_image[1]

    def close(self) -> None:
        """Destroy the sensor."""
        self._sensor.stop()
        self._sensor.destroy()


def _to_camera_image(raw: Any) -> CameraImage:
    """Return a BGRA image as JPEG."""
    from PIL import Image

    return as_jpeg(Image.frombuffer("RGB", (raw.width, raw.height), bytes(raw.raw_data), "raw", "BGRX", 0, 1))


def as_jpeg(picture: Any) -> CameraImage:
    """Return a `PIL.Image` as the JPEG image of a scene."""
    file = io.BytesIO()
    picture.save(file, "JPEG", quality=JPEG_QUALITY)
    return CameraImage(width=picture.width, height=picture.height, jpeg=base64.b64encode(file.getvalue()))
