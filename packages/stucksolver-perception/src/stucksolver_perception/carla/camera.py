"""The rig's front camera for reasoners: its latest image, in the size that all reasoners get."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stucksolver.scene import CameraImage
from stucksolver_carla.stack.front_camera import HEIGHT, WIDTH, as_jpeg
from stucksolver_perception.measurements import CameraFrame

if TYPE_CHECKING:
    from stucksolver_perception.carla.ego_perception import EgoPerception


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
