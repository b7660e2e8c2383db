"""When a snapshot may be sent: only when its readers are ready for it.

Four races in the client library make this necessary. All are likely with a server as fast as this one:

 * `sensor.listen()` returns before the client's connection to the stream exists, so the next frame would be
   lost. A snapshot therefore waits for every stream whose token was requested. A reader that is even later still
   gets the messages that it missed (`streaming`).
 * `load_world()` drops its episode as soon as the request is answered, in the same map of streams that the client's
   network thread uses while it takes a snapshot. Nothing guards that map. If both use it at once, the process ends
   ("close: Bad file descriptor", "bad_weak_ptr", or without a message). Therefore the answer comes some time after
   the last snapshot, and the next snapshot only after the client has subscribed again.
 * `sensor.destroy()` closes the sensor's connection in another thread, which requires Python's global lock to release
   the callback. `apply_batch_sync(…, True)` holds that lock while it waits for a snapshot. With two such threads (a
   machine with two cores) and two sensors being destroyed, no thread is left to read the snapshot, and the call times
   out. Therefore the answer to the destruction, for which the client waits without the lock, comes shortly after the
   connection is closed.
 * The traffic manager's worker thread ends a step with a request for the episode's settings, and then waits on a
   condition variable, which `world.tick()` notifies without holding its mutex. If the snapshot wakes the main thread
   at just that moment, the notification is lost and the client hangs forever. Therefore, while a traffic manager is
   registered, a snapshot waits until shortly after the settings were requested. The answer to a worker that requests
   them only after the snapshot is delayed by as much. The server uses this time to compute the frame, and lets the
   client sleep in the meantime: a client that has the frame's number busy-waits until the frame is there.

The numbers are ours.
"""

from __future__ import annotations

from collections import deque

HANDSHAKE_LIMIT_S = 1.0
"""Time for which a snapshot waits for streams whose token was requested (s)."""
PARTING_LIMIT_S = 0.25
"""Time for the subscribers of a sensor to close their connections (s). Others may stay subscribed."""
PARTING_REST_S = 0.02
"""Time from a closed connection to the answer (s).

The client's thread gets Python's lock in it, also on a busy machine.
"""
REST_S = 0.03
"""Time from the last snapshot of an episode to the answer that ends it (s)."""
RETURN_LIMIT_S = 0.5
"""Time for a client that has loaded a world to subscribe again (s). No snapshot is sent during it."""
SETTLE_S = 0.0005
"""Time from the reply until the worker waits on its condition variable (s)."""
DOUBT_S = 0.003
"""The same while it is unclear whether the worker or the client's own code requested the settings (s)."""
MEMORY_TICKS = 200
"""Number of snapshots over which the requests for settings are counted."""
STEP_LIMIT_S = 0.025
"""Time after which the snapshot is sent without the worker's request (s). It may be gone or asynchronous."""
ASK_LIMIT_S = 0.001
"""Longest time to wait for the worker's request before the tick is computed (s)."""


class SnapshotPacer:
    """Computes how long the snapshot of the current tick must still be held back. Times are monotonic (s)."""

    def __init__(self) -> None:
        self._cue = 0.0
        self._asked = 0.0
        self._asked_since_publish = 0
        self._published = -REST_S
        self._quiet_until = 0.0
        self._recent = deque([0], maxlen=MEMORY_TICKS)
        """Number of requests for the settings between two snapshots."""

    def cue(self, now: float) -> None:
        """Note that a client has requested a tick."""
        self._cue = now

    def settings_asked(self, now: float) -> None:
        """Note that a client (perhaps a traffic manager's worker) has received the settings."""
        self._asked = now
        self._asked_since_publish += 1

    def step_begun(self) -> None:
        """Note that a worker is in the middle of a step: it requested the light states, which others hardly do.

        Earlier requests belong to the start of the step: a late worker must not count as a waiting one.
        """
        self._asked_since_publish = 0

    def published(self, now: float, managers: int) -> None:
        """Note that the snapshot has been sent."""
        if managers:
            self._recent.append(self._asked_since_publish)
        self._asked_since_publish = 0
        self._published = now

    def episode_begun(self, now: float) -> float:
        """Note that a client loads a world; return the delay of its answer (s)."""
        rest = max(0.0, self._published + REST_S - now)
        self._quiet_until = now + rest + RETURN_LIMIT_S
        return rest

    def subscribed(self) -> None:
        """Note that a client has subscribed to the snapshots."""
        self._quiet_until = 0.0

    def quiet_s(self, now: float) -> float:
        """Return the time during which no snapshot may be sent because a client is about to change its stream (s)."""
        return max(0.0, self._quiet_until - now)

    def answer_after_s(self, now: float, managers: int) -> float:
        """Return the delay of the answer to a settings request (s).

        A worker that was late and requests them just after the snapshot must not reach its condition variable at the
        very moment at which the snapshot wakes the main thread.
        """
        return max(0.0, self._published + SETTLE_S - now) if managers else 0.0

    def awaits_worker(self, now: float, managers: int) -> bool:
        """True while a worker is about to request the settings: the answer should not wait for the tick."""
        return self._asked_since_publish < managers and now < self._cue + ASK_LIMIT_S

    def hold_s(self, now: float, managers: int, awaited_streams: int) -> float:
        """Return the longest time to wait before the next call (s); 0 means that the snapshot may be sent."""
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
        """True if only the short delay after the settings is left."""
        return not awaited_streams and now >= self._quiet_until and self._asked_since_publish >= managers
