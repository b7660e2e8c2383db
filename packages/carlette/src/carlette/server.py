"""The server: two listening ports, one thread, one loop."""

from __future__ import annotations

import contextlib
import errno
import logging
import os
import selectors
import socket
import time
from collections.abc import Callable
from typing import Any

from carlette.rpc.client_timeouts import timed_out_clients, unnamed_listeners
from carlette.rpc.connection import RpcConnection
from carlette.rpc.deferred_replies import DeferredReplies
from carlette.rpc.handlers import ALL
from carlette.rpc.session import ClientSession
from carlette.simulator import Simulator
from carlette.sockets import listen_pair, prepared
from carlette.streaming import Subscriber
from carlette.watchdog.pacing import ASK_LIMIT_S, PARTING_LIMIT_S, PARTING_REST_S, SnapshotPacer
from carlette.watchdog.traffic_manager import TrafficManagerWatchdog
from carlette.wire.encode import WORLD_STREAM

IDLE_S = 0.5
"""Longest sleep of the loop (s). Ours; it limits the delay of a stop."""
SHORTEST_PERIOD_S = 0.001
"""Least time between two ticks in asynchronous mode (s). Ours; it leaves time for requests at any step."""
SWITCHING_POLL_S = 0.001
"""Time between two checks while a traffic manager changes its mode (s). Ours."""

log = logging.getLogger(__name__)


class Server:
    """Serves one simulator until `stop` is called or `alive` returns False."""

    def __init__(self, simulator: Simulator, host: str, port: int) -> None:
        """Listen on `port` and `port + 1` (0: any free pair).

        Raises:
            StartupError: The ports cannot be used.
        """
        self.simulator = simulator
        self.host = host
        self._rpc_socket, self._stream_socket = listen_pair(host, port)
        self.port = int(self._rpc_socket.getsockname()[1])
        simulator.stream_port = self.port + 1
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._rpc_socket, selectors.EVENT_READ, self._accept_rpc)
        self._selector.register(self._stream_socket, selectors.EVENT_READ, self._accept_stream)
        self._sessions: dict[RpcConnection, ClientSession] = {}
        self._pacing = SnapshotPacer()
        self._rescue = TrafficManagerWatchdog()
        self._cued_by: RpcConnection | None = None
        self._owed: int | None = None
        """Number of the unanswered request of `_cued_by`; None without one."""
        self._is_cued = False
        """True if a client requested a frame that is not computed yet."""
        self._is_pending = False
        """True if the snapshot of a completed tick is still held back."""
        self._next_tick = time.monotonic()
        self._held = DeferredReplies()
        self._selector.register(self._held.woken, selectors.EVENT_READ, self._on_woken)
        self._spare_file = os.open(os.devnull, os.O_RDONLY)
        self._running = True

    def stop(self) -> None:
        """Make `serve` return soon. Safe in a signal handler."""
        self._running = False

    def serve(self, alive: Callable[[], bool] = lambda: True) -> None:
        """Run the loop until `stop`, or until `alive` (called twice a second) returns False."""
        try:
            checked = time.monotonic()
            while self._running:
                self._turn()
                now = time.monotonic()
                if now - checked > IDLE_S:
                    checked = now
                    # Not `running and alive()`: a signal in between would be lost.
                    if not alive():
                        self._running = False
        finally:
            self._close()

    def _turn(self) -> None:
        behind = [session for session in self._sessions if session.is_behind and not session.is_paused]
        self._handle_ready(0.0 if behind else self._held.wait_s(time.monotonic(), self._wait_s()))
        for item in behind:
            if item in self._sessions:
                self._handle(self._selector.get_key(item.socket), 0)
        now = time.monotonic()
        self._send_away_overstayed(now)
        self._held.release(now)
        if self._is_cued and not self._pacing.awaits_worker(now, len(self.simulator.traffic_managers)):
            self._tick()
        while self.simulator.ticks_wanted:
            self.simulator.ticks_wanted -= 1
            self._cue(now)
            self._tick()
        self._rescue.free_if_silent(now)
        settings = self.simulator.world.settings
        if self._is_pending:
            self._try_publish(time.monotonic())
        elif not settings.synchronous and now >= self._next_tick and not self._pacing.quiet_s(now):
            self._next_tick = max(self._next_tick + max(settings.step_s, SHORTEST_PERIOD_S), now)
            self._cue(now)
            self._tick()
            self._try_publish(time.monotonic())

    def _handle_ready(self, wait_s: float) -> None:
        for key, events in self._selector.select(wait_s):
            # The request of one peer may have closed the connection of another.
            if self._selector.get_map().get(key.fd) is key:
                self._handle(key, events)

    def _handle(self, key: selectors.SelectorKey, events: int) -> None:
        try:
            key.data(events)
        except Exception:
            # Catch everything: an error with one peer must not end the server for the others.
            log.exception("a peer is dropped: this is an error of the server, please report it")
            for connection in [session for session in self._sessions if session.socket is key.fileobj]:
                self._drop_client(connection)
            for subscriber in [item for item in self.simulator.hub.subscribers if item.socket is key.fileobj]:
                self._drop_subscriber(subscriber)

    def _wait_s(self) -> float:
        now = time.monotonic()
        if self._is_cued:
            return ASK_LIMIT_S
        if self._is_pending:
            return min(IDLE_S, self._hold_s(now))
        if not self.simulator.world.settings.synchronous:
            return min(IDLE_S, max(0.0, self._next_tick - now, self._pacing.quiet_s(now)))
        return IDLE_S

    def _cue(self, now: float) -> None:
        """Note that a tick is requested, and finish the previous ones."""
        if self._is_cued:
            self._tick()
        if self._is_pending:
            self._publish()
        self._is_cued = True
        self._pacing.cue(now)

    def _tick(self) -> None:
        self._is_cued = False
        self.simulator.tick()
        self._is_pending = True
        if self.simulator.traffic_managers:
            # Answer now: their workers request the settings of this step before its snapshot may be sent.
            self._answer_cue()

    def _answer_cue(self) -> None:
        """Send the client the number of the next frame.

        The client busy-waits for that frame, so the number is sent as late as possible.
        """
        number, self._owed = self._owed, None
        if number is not None and self._cued_by is not None:
            frame = self.simulator.world.frame + self._is_cued
            self._cued_by.reply(number, [[1, frame]])

    def _hold_s(self, now: float) -> float:
        managers = len(self.simulator.traffic_managers)
        if self._rescue.is_switching:
            # A traffic manager that is not in step would miss this snapshot, or use it twice.
            return SWITCHING_POLL_S
        return self._pacing.hold_s(now, managers, len(self.simulator.hub.awaited))

    def _try_publish(self, now: float) -> None:
        """Send the pending snapshot once its readers are ready; sleep only for a short rest."""
        while self._is_pending:
            hold = self._hold_s(now)
            if hold <= 0.0:
                self._publish()
                return
            is_settling = self._pacing.is_settling(
                now, len(self.simulator.traffic_managers), len(self.simulator.hub.awaited)
            )
            if self._rescue.is_switching or not is_settling:
                return
            # Sleep: the selector's clock ticks in milliseconds, and a busy-wait would take the worker's core.
            time.sleep(hold)
            # A client that requested the settings meanwhile gets its own delay.
            self._handle_ready(0.0)
            now = time.monotonic()

    def _publish(self) -> None:
        self._is_pending = False
        self.simulator.hub.wait_no_longer()
        self._pacing.published(time.monotonic(), len(self.simulator.traffic_managers))
        self.simulator.publish()
        self._answer_cue()
        if self._cued_by is not None:
            self._rescue.published(time.monotonic(), self._cued_by.host, self._cued_by.traffic_managers)
        self._tend_subscribers()

    def _on_woken(self, events: int) -> None:
        """Send the measurements that waited for a map's scenery, which is now built.

        They must not be sent before the snapshot of their tick.
        """
        del events
        self._held.drain()
        if not self._is_pending:
            self.simulator.sensors.publish()
            self._tend_subscribers()

    def _tend_subscribers(self) -> None:
        for subscriber in list(self.simulator.hub.subscribers):
            if subscriber.lags:
                self._drop_subscriber(subscriber)
            elif subscriber.wants_to_write:
                self._watch(subscriber, self._on_stream(subscriber))

    def _accept(self, listener: socket.socket) -> socket.socket | None:
        try:
            sock, _ = listener.accept()
        except OSError as error:
            if error.errno in (errno.EMFILE, errno.ENFILE):
                self._send_away(listener)
            # Otherwise the peer disconnected in the meantime.
            return None
        return prepared(sock)

    def _send_away(self, listener: socket.socket) -> None:
        """Accept a peer with the spare file descriptor and close it. Without a free one, it would wait forever."""
        os.close(self._spare_file)
        # The peer may have disconnected in the meantime.
        with contextlib.suppress(OSError):
            listener.accept()[0].close()
        self._spare_file = os.open(os.devnull, os.O_RDONLY)
        log.warning("no more open files: a peer was sent away; raise the limit (ulimit -n)")

    # -- requests

    def _accept_rpc(self, events: int) -> None:
        del events
        sock = self._accept(self._rpc_socket)
        if sock is not None:
            connection = RpcConnection(sock, self._dispatch)
            self._sessions[connection] = ClientSession(self.simulator, connection)
            self._selector.register(sock, selectors.EVENT_READ, self._on_rpc(connection))

    def _on_rpc(self, connection: RpcConnection) -> Callable[[int], None]:
        """Return the function that writes and reads for this client when the selector reports that it can."""

        def handle(events: int) -> None:
            if events & selectors.EVENT_WRITE:
                connection.write()
            wants_more = events & selectors.EVENT_READ or connection.is_behind
            if wants_more and not connection.is_paused and not connection.read():
                self._drop_client(connection)
            else:
                self._watch(connection, handle)

        return handle

    def _dispatch(self, connection: RpcConnection, number: int, method: str, arguments: list[Any]) -> None:
        if connection is self._cued_by:
            # A worker that ended its step in asynchronous mode would start another, so its calls wait for the mode.
            self._rescue.wait_for_switch()
            # A worker that was late for the snapshot requests the settings before it waits.
            self._rescue.note_call(has_begun=method != "get_episode_settings")
        if method == "tick_cue":
            self._cue(time.monotonic())
            self._cued_by = connection
            self._owed = number
            return
        if self._is_cued and method != "get_episode_settings":
            # Compute the requested tick first: requests after a tick belong to the time after it.
            self._tick()
        if method == "get_episode_settings":
            time.sleep(self._pacing.answer_after_s(time.monotonic(), len(self.simulator.traffic_managers)))
        call = ALL.calls.get(method)
        if call is None:
            log.warning("a client called '%s', which this server does not know", method)
            connection.reply(number, None, f"this server does not know the method '{method}'")
            return
        episode = self.simulator.episode_id
        result = call(self._sessions[connection], *arguments)
        if self.simulator.episode_id != episode:
            time.sleep(self._pacing.episode_begun(time.monotonic()))
        self._answer(connection, number, result)
        if method == "get_episode_settings":
            self._pacing.settings_asked(time.monotonic())
        elif method == "get_vehicle_light_states":
            self._pacing.step_begun()

    def _answer(self, connection: RpcConnection, number: int, result: Any) -> None:
        sceneries, self.simulator.sceneries = (
            [scenery for scenery in self.simulator.sceneries if not scenery.done()],
            [],
        )
        parting, self.simulator.parting = self.simulator.parting, None
        if parting is not None:
            self._held.hold(connection, number, result, [parting], PARTING_LIMIT_S, PARTING_REST_S)
        elif not sceneries:
            connection.reply(number, result)
        else:
            # The client's first measurement must not be late.
            self._held.hold(connection, number, result, sceneries)

    def _drop_client(self, connection: RpcConnection) -> None:
        # A stale registration would make other clients wait for a traffic manager that is gone.
        for port in connection.traffic_managers:
            self.simulator.traffic_managers.pop(port, None)
        self._sessions.pop(connection, None)
        self._held.forget(connection)
        if connection is self._cued_by:
            self._cued_by = None
            self._rescue.note_disconnect()
        self._selector.unregister(connection.socket)
        connection.socket.close()

    def _send_away_overstayed(self, now: float) -> None:
        for client, reason in timed_out_clients(list(self._sessions), now):
            log.warning("a client at %s is dropped: %s", client.host, reason)
            self._drop_client(client)
        for subscriber in unnamed_listeners(self.simulator.hub.subscribers, now):
            self._drop_subscriber(subscriber)

    # -- streams

    def _accept_stream(self, events: int) -> None:
        del events
        sock = self._accept(self._stream_socket)
        if sock is not None:
            subscriber = Subscriber(sock)
            self.simulator.hub.subscribers.add(subscriber)
            self._selector.register(sock, selectors.EVENT_READ, self._on_stream(subscriber))

    def _on_stream(self, subscriber: Subscriber) -> Callable[[int], None]:
        """Return the function that writes and reads for this subscriber when the selector reports that it can."""

        def handle(events: int) -> None:
            if events & selectors.EVENT_WRITE:
                subscriber.write()
            if events & selectors.EVENT_READ and not subscriber.read():
                self._drop_subscriber(subscriber)
                return
            if subscriber.stream_id:
                self.simulator.hub.arrived(subscriber)
                if subscriber.stream_id == WORLD_STREAM:
                    self._pacing.subscribed()
            self._watch(subscriber, handle)

        return handle

    def _drop_subscriber(self, subscriber: Subscriber) -> None:
        self.simulator.hub.note_departure(subscriber)
        self._selector.unregister(subscriber.socket)
        subscriber.socket.close()

    def _watch(self, peer: RpcConnection | Subscriber, handle: Callable[[int], None]) -> None:
        """Wait for write readiness only while there is something left to write."""
        wanted = 0 if peer.is_paused else selectors.EVENT_READ
        if peer.wants_to_write:
            wanted |= selectors.EVENT_WRITE
        key = self._selector.get_key(peer.socket)
        if key.events != wanted:
            self._selector.modify(peer.socket, wanted, handle)

    def _close(self) -> None:
        for key in list(self._selector.get_map().values()):
            sock = key.fileobj
            if isinstance(sock, socket.socket):
                sock.close()
        self._selector.close()
        self._held.close()
        os.close(self._spare_file)
