"""Checks each camera image, and removes an empty or frozen one from the scene."""

from __future__ import annotations

import hashlib

from stucksolver.scene import CameraImage, Scene

LEAST_BYTES_PER_PIXEL = 0.02
"""Least size of an image with content. A uniform JPEG spends 6 bits on a block of 64 luma samples and 4 bits on a block
of 256 chroma samples (Annex K tables). That is 0.016 bytes per pixel; a picture of a road takes several times as much.
"""
MOVED_M = 0.5
"""Progress with an unchanged image from which the image counts as frozen (m). Ours."""


class CameraHealth:
    """Check of images against the last image and the progress at that time."""

    def __init__(self) -> None:
        self._digest: bytes | None = None
        self._progress_m = 0.0

    def checked(self, scene: Scene, progress_m: float) -> tuple[Scene, str | None]:
        """Return the scene without an unusable image.

        Args:
            scene: Scene as the stack built it.
            progress_m: Progress along the route (m), to distinguish a frozen image from a stopped vehicle.

        Returns:
            Scene without an empty or frozen image, and the fault (None if the image is good).
        """
        if scene.image is None:
            return scene, None
        fault = self._fault(scene.image, progress_m)
        return (scene, None) if fault is None else (scene.model_copy(update={"image": None}), fault)

    def _fault(self, image: CameraImage, progress_m: float) -> str | None:
        if len(image.jpeg) < LEAST_BYTES_PER_PIXEL * image.width * image.height:
            return "the camera image shows nothing"
        digest = hashlib.sha256(image.jpeg).digest()
        if digest == self._digest:
            # A simulated camera may produce the same image twice while the vehicle is stopped.
            return "the camera image is frozen" if abs(progress_m - self._progress_m) > MOVED_M else None
        self._digest, self._progress_m = digest, progress_m
        return None
