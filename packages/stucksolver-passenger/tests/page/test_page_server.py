"""The server's process, and a desk that meets it."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import pytest

pytest.importorskip("uvicorn", reason="the extra `passenger` is not installed")
from sitting import PASSENGER_ASKED, parked

from stucksolver import StuckSolver
from stucksolver_passenger.gateway import PassengerGateway
from stucksolver_passenger.link import LinkError
from stucksolver_passenger.server.options import PageOptions, ServerOptionsError
from stucksolver_passenger.server.process import PassengerServer

LIMIT_S = 60.0
"""Who takes longer than that hangs; a busy machine may need seconds."""


def becomes(is_true):
    """Wait for something; whether it came true."""
    end = time.monotonic() + LIMIT_S
    while not is_true():
        if time.monotonic() > end:
            return False
        time.sleep(0.05)
    return True


@pytest.fixture(scope="module")
def server():
    with PassengerServer() as started:
        yield started


def read(server, path, token):
    request = urllib.request.Request(
        f"http://127.0.0.1:{server.port}{path}", headers={"authorization": f"Bearer {token}"}
    )
    with urllib.request.urlopen(request, timeout=LIMIT_S) as answer:
        return json.load(answer)


def test_vehicles_of_several_desks_meet_at_one_server(server):
    world = parked()
    for name in ("one", "two"):
        desk = PassengerGateway(server.address)
        solver = StuckSolver(world.scene, ladder=PASSENGER_ASKED, on_event=desk.ear(name))
        desk.add(name, solver, f"Car {name}").tick(world.status())
        desk.close()
    both = {"one": "Car one", "two": "Car two"}
    assert becomes(lambda: read(server, "/api/vehicles", server.tokens.operator()) == both)
    assert becomes(lambda: bool(read(server, "/api/vehicles/one", server.tokens.passenger("one"))["thought"]))


def test_by_default_only_this_machine_is_served(server):
    assert server.options.is_local
    with socket.socket() as own, pytest.raises(OSError):
        own.settimeout(1.0)
        own.connect((_other_address(), server.port))


def _other_address():
    """Another address of loopback's network: whoever listens everywhere listens there, too."""
    return "127.0.0.9"


def test_the_folder_of_the_socket_is_its_owners_alone(server):
    assert server.address.parent.stat().st_mode & 0o077 == 0


def test_gateway_duplicate_or_invalid_vehicle_id_is_rejected(server):
    """A vehicle can join a gateway once, and only under a valid id."""
    with PassengerGateway(server.address) as desk:
        solver = StuckSolver(parked().scene, ladder=PASSENGER_ASKED)
        desk.add("three", solver)
        with pytest.raises(ValueError, match="already in use"):
            desk.add("three", solver)
        with pytest.raises(ValueError, match="invalid vehicle id"):
            desk.add("../x", solver)


def test_without_a_server_a_desk_says_where_it_looked(tmp_path):
    with pytest.raises(LinkError, match="Start it first"):
        PassengerGateway(tmp_path / "nobody")


@pytest.mark.integration
def test_a_server_that_goes_away_does_not_stop_the_car():
    world = parked()
    with PassengerServer() as going:
        desk = PassengerGateway(going.address)
        solver = StuckSolver(world.scene, ladder=PASSENGER_ASKED, on_event=desk.ear("car-1"))
        seat = desk.add("car-1", solver)
    for _ in range(200):
        solver.step(world.status(), world.surroundings)
        seat.tick(world.status(), world.scene)
        desk.show_picture("car-1", b"x" * 100_000)
        world.drive(solver.step(world.status(), world.surroundings))
    desk.close()


@pytest.mark.slow
def test_the_server_ends_with_the_program_that_started_it():
    code = """
import os
from stucksolver_passenger.server.process import PassengerServer
if __name__ == "__main__":
    server = PassengerServer().__enter__()
    print(server.port, flush=True)
    os._exit(0)
"""
    started = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=LIMIT_S, check=True)
    port = int(started.stdout)

    def is_gone():
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", port)) != 0

    assert becomes(is_gone)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (PageOptions(listen="car"), "not an address"),
        (PageOptions(cert=Path("x")), "must be given together"),
        (PageOptions(cert=Path("x"), key=Path("y")), "not a certificate"),
    ],
)
def test_what_cannot_be_served_is_said_before_anything_starts(options, why):
    with pytest.raises(ServerOptionsError, match=why):
        PassengerServer(options)


def test_a_port_that_is_taken_is_named():
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(ServerOptionsError, match=f"127.0.0.1:{port}"), PassengerServer(PageOptions(port=port)):
            pass


def test_page_options_addresses_are_accepted_host_names():
    """The accepted host names are those of the listening address and the configured names."""
    assert PageOptions().addresses(80) == ("127.0.0.1:80", "localhost:80", "127.0.0.1", "localhost")
    assert PageOptions(listen="192.168.1.5", names=("car.example",)).addresses(8443) == (
        "car.example:8443",
        "192.168.1.5:8443",
    )
    assert "[::1]:9" in PageOptions(listen="::1").addresses(9)


@pytest.mark.integration
def test_with_a_certificate_it_is_https(tmp_path):
    cert, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    made = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost"]
    try:
        subprocess.run([*made, "-keyout", str(key), "-out", str(cert)], capture_output=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("openssl cannot make a certificate here")
    import ssl

    trusting = ssl.create_default_context(cafile=str(cert))
    trusting.check_hostname = False
    with PassengerServer(PageOptions(cert=cert, key=key)) as server:
        assert server.url("o.x").startswith("https://127.0.0.1:")
        request = urllib.request.Request(f"https://127.0.0.1:{server.port}/openapi.json")
        with urllib.request.urlopen(request, timeout=LIMIT_S, context=trusting) as answer:
            assert answer.status == 200
