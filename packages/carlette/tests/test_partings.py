"""A sensor's destruction is answered when the client's threads have surely let go of it."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from concurrent.futures import Future

import msgpack
import pytest

from carlette.rpc.connection import RpcConnection
from carlette.rpc.deferred_replies import DeferredReplies
from carlette.streaming import StreamHub, Subscriber
from raw_client import IMU, NOWHERE, SYNCHRONOUS, Raw, open_stream
from serving import running_server


@pytest.fixture
def ends() -> Iterator[tuple[socket.socket, socket.socket]]:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        ours = socket.create_connection(listener.getsockname())
        theirs, _ = listener.accept()
    yield ours, theirs
    ours.close()
    theirs.close()


def subscriber(sock: socket.socket, stream_id: int) -> Subscriber:
    found = Subscriber(sock)
    found.stream_id = stream_id
    return found


def test_a_stream_is_left_when_its_last_reader_is_gone(ends: tuple[socket.socket, socket.socket]) -> None:
    hub = StreamHub()
    readers = [subscriber(end, 7) for end in ends]
    hub.subscribers.update(readers)
    parting = hub.parting(7)
    hub.note_departure(readers[0])
    assert not parting.done()
    hub.note_departure(readers[1])
    assert parting.done()


def test_a_stream_that_nobody_reads_is_left_already() -> None:
    assert StreamHub().parting(7).done()


def test_deferred_reply_waits_for_rest_and_time_limit(
    ends: tuple[socket.socket, socket.socket],
) -> None:
    """A reply is sent after its condition and a rest time, and at the latest at its time limit."""
    ours, theirs = ends
    answers, connection = DeferredReplies(), RpcConnection(ours, lambda *_: None)
    left: Future[None] = Future()
    answers.hold(connection, 1, "left", [left], longest_s=1e9, rest_s=5.0)
    answers.hold(connection, 2, "stays", [Future()], longest_s=1e6)
    now = 1e8
    left.set_result(None)
    answers.release(now)
    assert answers.wait_s(now, 9.0) == 5.0
    unpacker = msgpack.Unpacker()
    unpacker.feed(theirs.recv(4096))
    assert [item[3] for item in unpacker] == ["stays"]
    answers.release(now + 5.0)
    unpacker.feed(theirs.recv(4096))
    assert [item[3] for item in unpacker] == ["left"]
    answers.close()


def test_an_answer_waits_for_all_and_each_of_them_wakes(ends: tuple[socket.socket, socket.socket]) -> None:
    ours, theirs = ends
    theirs.setblocking(False)
    answers, connection = DeferredReplies(), RpcConnection(ours, lambda *_: None)
    built: list[Future[None]] = [Future(), Future()]
    answers.hold(connection, 1, "built", built, longest_s=1e9)
    for item in built:
        with pytest.raises(BlockingIOError):
            answers.woken.recv(1)
        answers.release(1.0)
        with pytest.raises(BlockingIOError):
            theirs.recv(1)
        item.set_result(None)
        assert answers.woken.recv(64)
    answers.release(2.0)
    assert msgpack.unpackb(theirs.recv(4096))[3] == "built"
    answers.close()


@pytest.mark.integration
def test_destroying_sensor_read_by_another_blocks_no_client() -> None:
    """Destroying a sensor that another client reads is answered, and delays no other request."""
    with running_server() as port:
        raw = Raw(port)
        raw.call("set_episode_settings", SYNCHRONOUS)
        _, ((_, sensor),) = raw.call("spawn_actor", IMU, NOWHERE)
        stream = open_stream(port, int.from_bytes(sensor[-1][:4], "little"))
        raw.call("tick_cue")
        calls = [["destroy_actor", [False], sensor[0]], ["version", [False]]]
        requests = [[0, 90 + i, method, arguments] for i, (method, *arguments) in enumerate(calls)]
        raw.socket.sendall(b"".join(map(msgpack.packb, requests)))
        answered: list[int] = []
        while len(answered) < 2:
            raw.unpacker.feed(raw.socket.recv(4096))
            answered += [number for _, number, *_ in raw.unpacker]
        assert answered == [91, 90]
        stream.close()
        raw.socket.close()
