"""Thumbnails of the front camera's images, small enough for a page with many of them."""

from __future__ import annotations

import base64
import io

from stucksolver.scene import CameraImage

WIDTH_PX = 480
"""Width of a thumbnail (pixels).

Signs, lights and pedestrians are still recognizable, and an image takes about 10 kB. Ours.
"""
QUALITY = 70
"""JPEG quality. Ours."""


def thumbnail(image: CameraImage) -> str:
    """Return a JPEG at most `WIDTH_PX` wide, in base64."""
    from PIL import Image

    picture = Image.open(io.BytesIO(image.jpeg))
    width = min(WIDTH_PX, picture.width)
    small = picture.resize((width, max(1, round(picture.height * width / picture.width))))
    file = io.BytesIO()
    small.save(file, "JPEG", quality=QUALITY)
    return base64.b64encode(file.getvalue()).decode()
