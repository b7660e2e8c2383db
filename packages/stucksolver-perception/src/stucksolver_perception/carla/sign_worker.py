"""Reads signs while the ego is stopped: one crop per second, in a separate thread, never in the control loop.

In a world that waits (`paced`) a result is used exactly `DELAY_S` after its image, independent of the computing time,
so that a run can be repeated.
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

STOPPED_MPS = 0.2
"""Speed below which the ego counts as stopped (m/s). The noise of the wheels' speed is 0.05 m/s."""
MIN_STOPPED_S = 3.0
"""Time stopped after which reading starts (s). Before it, traffic usually moves on, or a light changes. Ours."""
PERIOD_S = 1.0
"""Time between two crops (s). A crop takes about 50 ms of one core."""
DELAY_S = 0.5
"""Time from the image to the use of the result in a world that waits (s). Ours."""
TICK_S = 1e-6
"""Tolerance of time comparisons (s): sums of ticks have rounding errors."""


ReadWords = dict[SignWord, WordLocation]
"""The words in a crop, each with its location."""


@dataclass(frozen=True)
class _RunningLook:
    time_s: float
    target: SignTarget
    future: Future[ReadWords]


class SignWorker:
    """The reading of signs. Call `tick` on every tick; `signs` contains the words that count."""

    def __init__(
        self,
        rig: CameraRig,
        reader: TextRecognizer | None,
        posts: Mapping[int, tuple[float, float]],
        *,
        paced: bool,
    ) -> None:
        """Create the worker. Without a `reader` no sign is read."""
        self._rig, self._reader, self._posts, self._paced = rig, reader, posts, paced
        self._worker = None if reader is None else ThreadPoolExecutor(1, "signs")
        self._filter = SignFilter()
        self._running: _RunningLook | None = None
        self._stopped_since_s: float | None = None
        self._started_s = self._picture_time_s = -math.inf
        self.signs: tuple[ObservedSign, ...] = ()
        """The words that count; empty while the ego moves."""

    def tick(self, now_s: float, pose: PoseEstimate, picture: CameraFrame | None, tracks: Sequence[Track]) -> None:
        """Collect a finished look, and start the next one if the ego has been stopped long enough."""
        if self._worker is None:
            return
        if abs(pose.speed_mps) > STOPPED_MPS:
            self._stopped_since_s = None
            self._filter.clear()
            self.signs = ()
        elif self._stopped_since_s is None:
            self._stopped_since_s = now_s
        self._collect_result(now_s)
        if self.signs:
            self.signs = self._filter.signs(now_s)
        since_s = self._stopped_since_s
        if since_s is None or self._running is not None or picture is None:
            return
        if picture.time_s < since_s or picture.time_s <= self._picture_time_s:
            return
        if now_s - max(since_s + MIN_STOPPED_S, self._started_s + PERIOD_S) >= -TICK_S:
            self._start_look(now_s, pose, picture, tracks)

    def close(self) -> None:
        """End the thread."""
        if self._worker is not None:
            self._worker.shutdown(wait=True, cancel_futures=True)

    def _start_look(self, now_s: float, pose: PoseEstimate, picture: CameraFrame, tracks: Sequence[Track]) -> None:
        candidates = targets(self._rig, pose, tracks, self._posts)
        target = self._filter.next_of(candidates, now_s)
        self._started_s, self._picture_time_s = now_s, picture.time_s
        if target is not None and self._worker is not None:
            if self._filter.count(target) % 2:
                target = target.widened(self._rig)
            self._running = _RunningLook(now_s, target, self._worker.submit(self._read, picture, target, candidates))

    def _read(self, picture: CameraFrame, target: SignTarget, candidates: Sequence[SignTarget]) -> ReadWords:
        assert self._reader is not None
        words: ReadWords = {}
        for look in self._reader.read(target.crop(picture.rgb), target.single):
            column, row = target.left + look.column, target.top + look.row
            carrier = carrier_of(look.word, column, row, candidates, target)
            words[look.word] = WordLocation(
                bearing_rad(self._rig, column), None if carrier is None else carrier.track_id
            )
        return words

    def _collect_result(self, now_s: float) -> None:
        look = self._running
        if look is None or not (now_s - look.time_s >= DELAY_S - TICK_S if self._paced else look.future.done()):
            return
        self._running = None
        try:
            words = look.future.result()
        except SignReaderError as error:
            # The drive continues without words on signs, because they are only an additional source.
            log_unavailable(str(error))
            self.close()
            self._worker, self.signs = None, ()
            return
        if self._stopped_since_s is not None and look.time_s >= self._stopped_since_s:
            self._filter.add(SignReadout(look.time_s, look.target, words))
            self.signs = self._filter.signs(now_s)


def make_sign_reader() -> SignReader | None:
    """Return the sign reader, or None if its package is missing (logged once)."""
    reason = unavailable_reason()
    if reason is not None:
        log_unavailable(reason)
    return None if reason else SignReader()


@functools.cache
def log_unavailable(reason: str) -> None:
    """Log once that signs are not read, with the reason. Of several processes, only the parent logs it."""
    if multiprocessing.parent_process() is None:
        print(f"stucksolver: {UNREAD}: {reason}", file=sys.stderr, flush=True)
