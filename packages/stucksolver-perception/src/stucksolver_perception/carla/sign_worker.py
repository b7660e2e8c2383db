"""Reads signs while the ego stands: in a thread of its own, one crop a second, never in the control loop.

In a world that waits (`paced`) a result is used exactly `DELAY_S` after its image, however long it took, so that a
drive can be repeated.
"""

from __future__ import annotations

import functools
import math
import multiprocessing
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

from stucksolver.scene import ObservedSign, SignWord
from stucksolver_perception.camera.sign_filter import SignFilter, SignReadout, WordLocation
from stucksolver_perception.camera.sign_reader import (
    UNREAD,
    SignReader,
    SignReaderError,
    TextRecognizer,
    unavailable_reason,
)
from stucksolver_perception.camera.sign_targets import SignTarget, bearing_rad, carrier_of, targets
from stucksolver_perception.measurements import CameraFrame, PoseEstimate
from stucksolver_perception.rig import CameraRig
from stucksolver_perception.tracking import Track

STANDS_MPS = 0.2
"""Below this speed the ego stands: the noise of its wheels' speed is 0.05 m/s."""
STOOD_S = 3.0
"""Reading begins after this time at rest, so it costs nothing in traffic and at a light that changes soon."""
PERIOD_S = 1.0
"""From one crop to the next: a crop takes some 50 ms of one core."""
DELAY_S = 0.5
"""From the image to the use of the result in a world that waits."""
TICK_S = 1e-6


Found = dict[SignWord, WordLocation]
"""The words in a crop, each with its place."""


@dataclass(frozen=True)
class _UnderWay:
    time_s: float
    target: SignTarget
    future: Future[Found]


class SignWorker:
    """Call `tick` on every tick; `signs` are the words that count."""

    def __init__(
        self,
        rig: CameraRig,
        reader: TextRecognizer | None,
        posts: Mapping[int, tuple[float, float]],
        *,
        paced: bool,
    ) -> None:
        """With `reader` None nothing is read."""
        self._rig, self._reader, self._posts, self._paced = rig, reader, posts, paced
        self._worker = None if reader is None else ThreadPoolExecutor(1, "signs")
        self._memory = SignFilter()
        self._under_way: _UnderWay | None = None
        self._stands_since_s: float | None = None
        self._begun_s = self._pictured_s = -math.inf
        self.signs: tuple[ObservedSign, ...] = ()
        """Empty as soon as the ego moves."""

    def tick(self, now_s: float, pose: PoseEstimate, picture: CameraFrame | None, tracks: Sequence[Track]) -> None:
        """Take a finished look, and begin the next one if the ego has stood long enough."""
        if self._worker is None:
            return
        if abs(pose.speed_mps) > STANDS_MPS:
            self._stands_since_s = None
            self._memory.clear()
            self.signs = ()
        elif self._stands_since_s is None:
            self._stands_since_s = now_s
        self._take_up(now_s)
        if self.signs:
            self.signs = self._memory.signs(now_s)
        since_s = self._stands_since_s
        if since_s is None or self._under_way is not None or picture is None:
            return
        if picture.time_s < since_s or picture.time_s <= self._pictured_s:
            return
        if now_s - max(since_s + STOOD_S, self._begun_s + PERIOD_S) >= -TICK_S:
            self._begin(now_s, pose, picture, tracks)

    def close(self) -> None:
        """End the thread."""
        if self._worker is not None:
            self._worker.shutdown(wait=True, cancel_futures=True)

    def _begin(self, now_s: float, pose: PoseEstimate, picture: CameraFrame, tracks: Sequence[Track]) -> None:
        places = targets(self._rig, pose, tracks, self._posts)
        target = self._memory.next_of(places, now_s)
        self._begun_s, self._pictured_s = now_s, picture.time_s
        if target is not None and self._worker is not None:
            if self._memory.count(target) % 2:
                target = target.widened(self._rig)
            self._under_way = _UnderWay(now_s, target, self._worker.submit(self._read, picture, target, places))

    def _read(self, picture: CameraFrame, target: SignTarget, places: Sequence[SignTarget]) -> Found:
        assert self._reader is not None
        found: Found = {}
        for item in self._reader.read(target.crop(picture.rgb), target.single):
            column, row = target.left + item.column, target.top + item.row
            carrier = carrier_of(item.word, column, row, places, target)
            found[item.word] = WordLocation(
                bearing_rad(self._rig, column), None if carrier is None else carrier.track_id
            )
        return found

    def _take_up(self, now_s: float) -> None:
        item = self._under_way
        if item is None or not (now_s - item.time_s >= DELAY_S - TICK_S if self._paced else item.future.done()):
            return
        self._under_way = None
        try:
            found = item.future.result()
        except SignReaderError as error:
            log_unavailable(str(error))
            self.close()
            self._worker, self.signs = None, ()
            return
        if self._stands_since_s is not None and item.time_s >= self._stands_since_s:
            self._memory.add(SignReadout(item.time_s, item.target, found))
            self.signs = self._memory.signs(now_s)


def make_sign_reader() -> SignReader | None:
    """Return the reader, or None if its package is not installed, which is told once."""
    why = unavailable_reason()
    if why is not None:
        log_unavailable(why)
    return None if why else SignReader()


@functools.cache
def log_unavailable(why: str) -> None:
    """Say once that signs are not read, and why. The parent of many drives says so for all of them."""
    if multiprocessing.parent_process() is None:
        print(f"stucksolver: {UNREAD}: {why}", file=sys.stderr, flush=True)
