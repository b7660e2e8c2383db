"""Slots of connections: which one gives way to a new one, and when one ends by itself."""

from __future__ import annotations

import asyncio
import socket
import ssl
import subprocess
import threading
from contextlib import contextmanager

import pytest

pytest.importorskip("uvicorn", reason="the extra `passenger` is not installed")
from attacking import ended, head, status_of
from hypothesis import given, settings
from hypothesis import strategies as st

from stucksolver_passenger.server.connection_limits import ConnectionLimits, ConnectionSlots, source_of
from stucksolver_passenger.server.http_server import make_server, serve, tls_of
from stucksolver_passenger.server.request_filter import RequestFilter

HASTY = ConnectionLimits(request_s=0.3, idle_s=0.3, answer_s=0.3)


async def answering(scope, receive, send):
    """Answer with what was sent; a path `/long` has an answer that nobody can read at once."""
    if scope["type"] == "lifespan":
        while (await receive())["type"] != "lifespan.shutdown":
            await send({"type": "lifespan.startup.complete"})
        await send({"type": "lifespan.shutdown.complete"})
        return
    parts = [b"x" * 100_000] * 500 if scope["path"] == "/long" else [(await receive())["body"]]
    headers = [(b"content-length", str(sum(map(len, parts))).encode())]
    await send({"type": "http.response.start", "status": 200, "headers": headers})
    for part in parts:
        await send({"type": "http.response.body", "body": part, "more_body": True})
    await send({"type": "http.response.body", "body": b""})


@contextmanager
def serving(limits=HASTY, tls=None):
    """A real server whose doors know one token: `good`."""
    listening = socket.create_server(("127.0.0.1", 0))
    port = listening.getsockname()[1]

    def shares(path, authorization):
        return (("good", 2),) if authorization == "Bearer good" else ()

    server = make_server(RequestFilter(answering, frozenset({f"127.0.0.1:{port}"}), "http", shares=shares), limits, tls)
    thread = threading.Thread(target=lambda: asyncio.run(serve(server, [listening])), daemon=True)
    thread.start()
    try:
        yield port
    finally:
        server.should_exit = True
        thread.join(30)


def connect(port):
    return socket.create_connection(("127.0.0.1", port), timeout=60.0)


def name(port):
    return f"127.0.0.1:{port}"


ENDLESS = {
    "silent": lambda host: b"",
    "half a head": lambda host: head("GET", "/", host)[:-2],
    "half a body": lambda host: head("POST", "/", host, length=100) + b"{",
    "half a body of a holder": lambda host: head("POST", "/", host, token="good", length=100) + b"{",
    "an unread answer": lambda host: head("GET", "/long", host),
    "an unread answer of a holder": lambda host: head("GET", "/long", host, token="good"),
    "idle after an answer": lambda host: head("GET", "/", host),
    "a body that a GET has not": lambda host: head("GET", "/", host, length=1000) + b"x",
    "chunks": lambda host: (
        head("POST", "/", host)[:-2] + b"content-type: application/json\r\ntransfer-encoding: chunked\r\n\r\n1\r\n{\r\n"
    ),
}


@pytest.mark.parametrize("kind", ENDLESS)
def test_connection_without_progress_is_ended(kind):
    with serving() as port, connect(port) as one:
        one.sendall(ENDLESS[kind](name(port)))
        if "unread" in kind:
            threading.Event().wait(2.0)  # nothing is read meanwhile
        assert ended(one)


@pytest.mark.parametrize("start", ["half a head", "half a body", "half a body of a holder", "chunks"])
def test_connection_that_drips_bytes_is_ended(start):
    """More bytes give a request no more time."""
    with serving() as port, connect(port) as one:
        one.sendall(ENDLESS[start](name(port)))
        drip = b"1\r\n \r\n" if start == "chunks" else b" "
        with pytest.raises(OSError):
            for _ in range(600):
                one.sendall(drip)
                threading.Event().wait(0.1)


def test_connection_with_requests_in_time_stays():
    """Each request has its own time."""
    limits = ConnectionLimits(request_s=20.0, idle_s=20.0, answer_s=20.0)
    with serving(limits) as port, connect(port) as one:
        for _ in range(5):
            one.sendall(head("POST", "/", name(port), length=2) + b"{}")
            assert status_of(one) == 200
            while not one.recv(1 << 16).endswith(b"{}"):
                pass


def test_connection_beyond_the_limit_ends_the_oldest_one():
    limits = ConnectionLimits(waiting=3)
    with serving(limits) as port:
        held = []
        for _ in range(6):
            held.append(connect(port))
            held[-1].sendall(head("GET", "/", name(port))[:5])
        assert [ended(item) for item in held[:3]] == [True] * 3
        for item in held[3:]:
            item.sendall(head("GET", "/", name(port))[5:])
        assert [status_of(item) for item in held[3:]] == [200] * 3


def test_connection_of_a_holder_is_not_ended_by_newer_ones():
    """Up to the holder's share; then its connections are as any other."""
    limits = ConnectionLimits(waiting=3)
    with serving(limits) as port:
        own = [connect(port) for _ in range(3)]
        for item in own:
            item.sendall(head("POST", "/", name(port), token="good", length=2) + b"{")
            item.settimeout(60.0)
        threading.Event().wait(0.5)
        others = [connect(port) for _ in range(8)]
        for item in own[:2]:
            item.sendall(b"}")
        assert [status_of(item) for item in own] == [200, 200, 0]
        for item in (*own, *others):
            item.close()


def test_client_that_sends_far_ahead_is_ended():
    with serving(ConnectionLimits(ahead_bytes=10_000)) as port, connect(port) as one:
        one.sendall(head("GET", "/long", name(port)))
        threading.Event().wait(0.5)
        with pytest.raises(ConnectionError):
            for _ in range(2000):
                one.sendall(head("GET", "/", name(port)) * 1000)


@pytest.fixture(scope="module")
def certificate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tls")
    cert, key = folder / "cert.pem", folder / "key.pem"
    made = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost"]
    try:
        subprocess.run([*made, "-keyout", str(key), "-out", str(cert)], capture_output=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("openssl cannot make a certificate here")
    return cert, key


def test_connection_without_a_tls_handshake_is_counted_and_ended(certificate):
    cert, key = certificate
    trusting = ssl.create_default_context(cafile=str(cert))
    trusting.check_hostname = False
    with serving(ConnectionLimits(waiting=3), tls_of(str(cert), str(key))) as port:
        silent = []
        for _ in range(6):
            silent.append(connect(port))
            silent[-1].sendall(b"\x16")
        assert [ended(item) for item in silent[:3]] == [True] * 3
        with trusting.wrap_socket(connect(port)) as secured:
            secured.sendall(head("POST", "/", name(port), length=2) + b"{}")
            assert status_of(secured) == 200
    with serving(HASTY, tls_of(str(cert), str(key))) as port, connect(port) as one:
        one.sendall(b"\x16\x03\x01")
        assert ended(one)


@pytest.mark.parametrize(
    ("address", "source"),
    [
        ("192.0.2.7", "192.0.2.7"),
        ("::ffff:192.0.2.7", "192.0.2.7"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("", ""),
    ],
)
def test_source_of_an_address_is_one_client(address, source):
    assert source_of(address) == source


def test_connections_of_one_address_do_not_end_those_of_another():
    async def run():
        gone = []
        slots = ConnectionSlots(ConnectionLimits(waiting=5))
        slots.take("192.0.2.1", lambda: gone.append("passenger"))
        for i in range(100):
            slots.take(f"2001:db8::{i:x}", lambda: gone.append("attacker"))
        return gone, slots.waiting

    gone, waiting = asyncio.run(run())
    assert set(gone) == {"attacker"} and waiting == 5


@given(st.lists(st.tuples(st.sampled_from("tharl"), st.integers(0, 9)), max_size=80))
@settings(max_examples=150, deadline=None)
def test_slots_after_any_history_count_what_is_there(history):
    """No order of calls loses a slot, counts one twice, or exceeds a limit."""

    async def run():
        slots, made = ConnectionSlots(ConnectionLimits(waiting=4)), []
        for call, which in history:
            if call == "t":
                ended = []
                made.append((slots.take(f"192.0.2.{which % 3}", lambda ended=ended: ended.append(1)), ended))
            elif made:
                slot, _ = made[which % len(made)]
                {
                    "h": lambda slot=slot: slot.hold(("one", 2), ("all", 3)),
                    "a": slot.answered,
                    "r": slot.request_read,
                    "l": slot.leave,
                }[call]()
            assert slots.waiting <= 4
        here = [slot for slot, ended in made if not ended and not slot._left]
        assert slots.waiting == sum(not slot.held_for for slot in here)
        assert sum(bool(slot.held_for) for slot in here) <= 2
        for slot in here:
            slot.leave()
        assert slots.waiting == 0 and not slots._waiting and not +slots._held

    asyncio.run(run())
