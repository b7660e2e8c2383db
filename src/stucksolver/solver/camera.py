"""Is a camera image worth looking at? A black or frozen one is left out of the scene: unknown is None."""

from __future__ import annotations

import hashlib

from stucksolver.scene import CameraImage, Scene

LEAST_BYTES_PER_PIXEL = 0.02
"""A JPEG of one even colour spends 6 bits on a block of 64 luma samples and 4 on one of 256 chroma samples (Annex K
tables), 0.016 bytes a pixel; a picture of a road takes several times that."""
MOVED_M = 0.5


class CameraWatch:
    """Remembers the last image, and where it was taken."""

    def __init__(self) -> None:
        self._digest: bytes | None = None
        self._progress_m = 0.0

    def checked(self, scene: Scene, progress_m: float) -> tuple[Scene, str | None]:
        """The scene without an image that shows nothing, or an old one; and what was wrong with it."""
        if scene.image is None:
            return scene, None
        fault = self._fault(scene.image, progress_m)
        return (scene, None) if fault is None else (scene.model_copy(update={"image": None}), fault)

    def _fault(self, image: CameraImage, progress_m: float) -> str | None:
        if len(image.jpeg) < LEAST_BYTES_PER_PIXEL * image.width * image.height:
            return "the camera image shows nothing"
        digest = hashlib.sha256(image.jpeg).digest()
        if digest == self._digest:
            # Where the vehicle stands still, a simulated camera may well see the very same again.
            return "the camera image is frozen" if abs(progress_m - self._progress_m) > MOVED_M else None
        self._digest, self._progress_m = digest, progress_m
        return None
