"""The software rasteriser: OpenGL 1.1 in the processor, out of the package `raylib_software`.

That package's library holds `rlsw`, which needs neither a window nor a display: it draws into memory that we read. It
is called by its C names. It has one state for the whole process, so `RASTER_LOCK` guards a frame; calls release
Python's lock while they draw.

What the depth buffer holds is read by a detour: its texture (four bytes for each pixel) is bound as a colour buffer,
and the pixels are copied out like colours.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from carlette.camera.arrays import Bytes, Pixels, Singles
from carlette.errors import UsageError

RASTER_LOCK = threading.Lock()

_QUADS = 0x0007
_DEPTH_TEST, _CULL_FACE, _BLEND = 0x0B71, 0x0B44, 0x0BE2
_BACK = 0x0405
_PROJECTION, _MODELVIEW = 0x1701, 0x1700
_VERTEX_ARRAY, _COLOR_ARRAY = 0x8074, 0x8076
_DEPTH_BIT, _COLOR_BIT = 0x0100, 0x4000
_SRC_ALPHA, _ONE_MINUS_SRC_ALPHA, _ONE_MINUS_DST_COLOR, _ONE = 0x0302, 0x0303, 0x0307, 1
_RGBA, _UNSIGNED_BYTE = 0x1908, 0x1401
_RGBA8, _DEPTH32 = 0x8058, 0x81A7
_COLOR_ATTACHMENT, _DEPTH_ATTACHMENT = 0x8CE0, 0x8D00


class Raster:
    """Draws flat-coloured quads into one picture at a time. Hold `RASTER_LOCK` from `begin` to the last read."""

    def __init__(self) -> None:
        self._library = _library()
        self._size = (0, 0)
        self._is_open = False
        self._off_screen: dict[tuple[int, int], _Target] = {}

    def begin(self, width: int, height: int, projection: Singles) -> Pixels:
        """Begins a picture with an empty depth buffer.

        `projection` is 4x4, from the frame in which `draw` gets its matrices to clip space; its y points down.
        Returns the colour buffer, uint32 (height, width), first row on top, its bytes in the order of `draw`'s colours:
        fill it with a background.
        """
        library = self._library
        self._open(width, height)
        library.swBindFramebuffer(0)
        return self._start(width, height, projection)

    def begin_with_depth(self, width: int, height: int, projection: Singles) -> None:
        """Like `begin`, into buffers of which `depth` can be read."""
        self._open(width, height)
        target = self._off_screen.get((width, height))
        if target is None:
            if len(self._off_screen) >= 2:
                for one in self._off_screen.values():
                    one.free(self._library)
                self._off_screen.clear()
            target = self._off_screen[width, height] = _Target(self._library, width, height)
        self._library.swBindFramebuffer(target.draw)
        self._start(width, height, projection)

    def draw(self, corners: Singles, colors: Bytes, matrix: Singles | None = None) -> None:
        """Draws quads: `corners` (n, 4, 3) float32, `colors` (n, 4, 4) uint8, four bytes a pixel, both contiguous.

        `matrix` (4x4) leads from their frame to the one of `projection`; None = that of the last `place` or `draw`.
        A quad's front is where (second - first) x (last - first) points to; backs are not drawn.
        """
        library = self._library
        if matrix is not None:
            self.place(matrix)
        library.swBindArray(_VERTEX_ARRAY, corners.__array_interface__["data"][0])
        library.swBindArray(_COLOR_ARRAY, colors.__array_interface__["data"][0])
        library.swDrawArrays(_QUADS, 0, 4 * len(corners))

    def place(self, matrix: Singles) -> None:
        """Sets the frame of what is drawn without a matrix of its own."""
        self._library.swLoadIdentity()
        self._library.swMultMatrixf(np.ascontiguousarray(matrix.T, np.float32).ctypes.data)

    def blend(self, *, add: bool = False) -> None:
        """From now on colours with an alpha below 255 are mixed into the picture, or all are added to it as light.

        Added light never gets brighter than white (the raster does not saturate): d + s (1 - d).
        """
        self._library.swEnable(_BLEND)
        if add:
            self._library.swBlendFunc(_ONE_MINUS_DST_COLOR, _ONE)
        else:
            self._library.swBlendFunc(_SRC_ALPHA, _ONE_MINUS_SRC_ALPHA)

    def use_depth(self, wanted: bool) -> None:
        """Whether nearer things hide what is drawn from now on."""
        (self._library.swEnable if wanted else self._library.swDisable)(_DEPTH_TEST)

    def depth(self) -> Singles:
        """The depth buffer of a picture begun with `begin_with_depth`: (height, width), -1 near to 1 far."""
        width, height = self._size
        target = self._off_screen[width, height]
        raw = np.empty((height, width, 4), np.uint8)
        self._library.swBindFramebuffer(target.read)
        self._library.swReadPixels(0, 0, width, height, _RGBA, _UNSIGNED_BYTE, raw.ctypes.data)
        self._library.swBindFramebuffer(target.draw)
        # Copied as a colour picture: upside down, and the first and third byte exchanged.
        raw[..., [0, 2]] = raw[..., [2, 0]]
        flipped: Singles = raw.view(np.float32)[::-1, :, 0]
        return flipped

    def _open(self, width: int, height: int) -> None:
        if not self._is_open:
            with _silenced():
                is_ready = self._library.swInit(width, height)
            if not is_ready:
                raise UsageError("the software renderer found no memory for its picture; close other programs")
            self._is_open = True
        elif self._size != (width, height):
            self._library.swBindFramebuffer(0)
            self._library.swResize(width, height)
        self._size = (width, height)

    def _start(self, width: int, height: int, projection: Singles) -> Pixels:
        library = self._library
        library.swViewport(0, 0, width, height)
        library.swClear(_DEPTH_BIT)
        library.swEnable(_CULL_FACE)
        library.swCullFace(_BACK)
        library.swEnable(_DEPTH_TEST)
        library.swDisable(_BLEND)
        library.swMatrixMode(_PROJECTION)
        library.swLoadIdentity()
        library.swMultMatrixf(np.ascontiguousarray(projection.T, np.float32).ctypes.data)
        library.swMatrixMode(_MODELVIEW)
        address = library.swGetColorBuffer(None, None)
        pixels = (ctypes.c_uint32 * (width * height)).from_address(address)
        buffer: Pixels = np.ctypeslib.as_array(pixels).reshape(height, width)
        return buffer


class _Target:
    """An off-screen colour and depth buffer, and a view of the depth as if it were colour."""

    def __init__(self, library: Any, width: int, height: int) -> None:
        self._textures = (ctypes.c_uint32 * 2)()
        self._buffers = (ctypes.c_uint32 * 2)()
        library.swGenTextures(2, self._textures)
        for texture, kind in zip(self._textures, (_RGBA8, _DEPTH32), strict=True):
            library.swBindTexture(texture)
            library.swTexStorage2D(width, height, kind)
        library.swBindTexture(0)
        library.swGenFramebuffers(2, self._buffers)
        self.draw, self.read = self._buffers
        library.swBindFramebuffer(self.draw)
        library.swFramebufferTexture2D(_COLOR_ATTACHMENT, self._textures[0])
        library.swFramebufferTexture2D(_DEPTH_ATTACHMENT, self._textures[1])
        library.swBindFramebuffer(self.read)
        library.swFramebufferTexture2D(_COLOR_ATTACHMENT, self._textures[1])

    def free(self, library: Any) -> None:
        library.swDeleteFramebuffers(2, self._buffers)
        library.swDeleteTextures(2, self._textures)


@contextmanager
def _silenced() -> Iterator[None]:
    """Keeps what a C library prints off the standard output, on which callers of the server read its own words."""
    libc = ctypes.CDLL(None)
    libc.fflush(None)
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        libc.fflush(None)
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


@lru_cache(maxsize=1)
def the_raster() -> Raster:
    """The raster of this process; raises `UsageError` where its package is not installed."""
    return Raster()


def _library() -> Any:
    spec = importlib.util.find_spec("raylib")
    places = list(spec.submodule_search_locations or []) if spec else []
    found = [path for place in places for path in sorted(Path(place).glob("_raylib_cffi*.so"))]
    if not found:
        raise UsageError("cameras need the package 'raylib_software'; pip install 'carlette[camera]'")
    library = ctypes.CDLL(str(found[0]))
    try:
        library.swGetColorBuffer.restype = ctypes.c_void_p
    except AttributeError:
        raise UsageError(
            "the installed 'raylib' draws with a graphics card; uninstall it and install 'raylib_software'"
        ) from None
    for name in ("swMultMatrixf",):
        getattr(library, name).argtypes = [ctypes.c_void_p]
    library.swBindArray.argtypes = [ctypes.c_int, ctypes.c_void_p]
    library.swReadPixels.argtypes = [*[ctypes.c_int] * 6, ctypes.c_void_p]
    return library
