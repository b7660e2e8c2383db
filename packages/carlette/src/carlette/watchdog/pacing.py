"""When a snapshot may be sent: not before its readers are ready for it.

Four races of the client library make this necessary; all are wide open with a server as fast as this one:

* `sensor.listen()` returns before the client's connection to the stream exists, so the next frame would be
  lost. A snapshot therefore waits for every stream whose token was asked for, and a reader that is later still gets
  what it missed (`hub`).
* `load_world()` drops its episode as soon as the request is answered, in the very map of streams that the client's
  network thread uses while it takes a snapshot; nothing guards it, and if both meet, the process ends ("close: Bad
  file descriptor", "bad_weak_ptr", or without a word). So the answer comes some time after the last snapshot, and the
  next snapshot not before the client has subscribed again.
* `sensor.destroy()` closes the sensor's connection in another thread, which needs Python's lock to forget the callback.
  `apply_batch_sync(…, True)` keeps that lock while it waits for a snapshot. With two such threads (a machine with two
  cores) and two sensors on their way out nobody is left to read it, and the call times out. So the answer to the
  destruction, for which the client waits without the lock, comes when the connection is closed, and a little later.
* The traffic manager's worker thread ends a step by asking for the episode's settings and then waits on a
  condition variable, which `world.tick()` notifies without holding its mutex. If the snapshot wakes the main
  thread in just that moment, the notification is lost and the client hangs for ever. So while a traffic
  manager is registered, a snapshot waits until the settings were asked for and a little longer; and the
  answer to a worker that asks only after the snapshot is put off as long. The server uses this time to compute
  the frame, and lets the client sleep meanwhile: who knows the frame's number spins until the frame is there.
"""

from __future__ import annotations

from collections import deque

HANDSHAKE_LIMIT_S = 1.0
PARTING_LIMIT_S = 0.25
"""For the clients that listened to a sensor to close their connections; another one may go on listening."""
PARTING_REST_S = 0.02
"""From a closed connection to the answer: the way of the client's thread to Python's lock, on a busy machine, too."""
REST_S = 0.03
"""From the last snapshot of an episode to the answer that ends it."""
RETURN_LIMIT_S = 0.5
"""For a client that loaded a world to subscribe again; in this time nobody gets a snapshot."""
SETTLE_S = 0.0005
"""The worker's way from the reply to its condition variable."""
DOUBT_S = 0.003
"""Instead, while it is open whether the worker or the client's own code asked for the settings."""
MEMORY_TICKS = 200
STEP_LIMIT_S = 0.025
"""Send after this time even if the worker never asked: it may be gone or in asynchronous mode."""
ASK_LIMIT_S = 0.001
"""The tick is not computed before the worker has asked, or this time is over: its way is used for computing."""


class Pacing:
    """Tells how long the snapshot of the current tick must still be held back. Times are monotonic seconds."""

    def __init__(self) -> None:
        self._cue = 0.0
        self._asked = 0.0
        self._asked_since_publish = 0
        self._published = -REST_S
        self._quiet_until = 0.0
        self._recent = deque([0], maxlen=MEMORY_TICKS)
        """How often the settings were asked for between two snapshots."""

    def cue(self, now: float) -> None:
        """A client asked for a tick."""
        self._cue = now

    def settings_asked(self, now: float) -> None:
        """A client (perhaps a traffic manager's worker) was told the settings."""
        self._asked = now
        self._asked_since_publish += 1

    def step_begun(self) -> None:
        """A worker is in the middle of a step (it asked for the light states, which others hardly do).

        What was asked before belongs to the step's begin: a late worker must not be taken for a waiting one.
        """
        self._asked_since_publish = 0

    def published(self, now: float, managers: int) -> None:
        """The snapshot is out."""
        if managers:
            self._recent.append(self._asked_since_publish)
        self._asked_since_publish = 0
        self._published = now

    def episode_begun(self, now: float) -> float:
        """A client loads a world: returns how many seconds its answer must wait."""
        rest = max(0.0, self._published + REST_S - now)
        self._quiet_until = now + rest + RETURN_LIMIT_S
        return rest

    def subscribed(self) -> None:
        """A client has come for the snapshots."""
        self._quiet_until = 0.0

    def quiet_s(self, now: float) -> float:
        """Seconds in which no snapshot may be sent, because a client is about to change its stream."""
        return max(0.0, self._quiet_until - now)

    def answer_after_s(self, now: float, managers: int) -> float:
        """Seconds by which the answer to a settings request is put off.

        A worker that was late and asks just after the snapshot must not reach its condition variable in the
        very moment in which the snapshot wakes the main thread.
        """
        return max(0.0, self._published + SETTLE_S - now) if managers else 0.0

    def awaits_worker(self, now: float, managers: int) -> bool:
        """True while a worker is about to ask for the settings: the answer should not wait for the tick."""
        return self._asked_since_publish < managers and now < self._cue + ASK_LIMIT_S

    def hold_s(self, now: float, managers: int, awaited_streams: int) -> float:
        """Seconds to wait at most before asking again; 0 = publish now."""
        if now < self._quiet_until:
            return self._quiet_until - now
        if awaited_streams and now < self._cue + HANDSHAKE_LIMIT_S:
            return self._cue + HANDSHAKE_LIMIT_S - now
        if not managers:
            return 0.0
        if self._asked_since_publish < managers and now < self._cue + STEP_LIMIT_S:
            return self._cue + STEP_LIMIT_S - now
        is_doubtful = self._asked_since_publish < max(self._recent) and self._asked < self._cue
        return max(0.0, max(self._cue, self._asked) + (DOUBT_S if is_doubtful else SETTLE_S) - now)

    def is_settling(self, now: float, managers: int, awaited_streams: int) -> bool:
        """True when only the short rest after the settings is left."""
        return not awaited_streams and now >= self._quiet_until and self._asked_since_publish >= managers
