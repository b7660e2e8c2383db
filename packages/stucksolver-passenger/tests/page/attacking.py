"""Raw connections to a real server, as an attacker holds them, and the requests of those who must still be served."""

from __future__ import annotations

import contextlib
import http.client
import json
import resource
import socket
import time
from dataclasses import dataclass

from sitting import PASSENGER_ASKED, parked

from stucksolver import StuckSolver
from stucksolver_passenger.gateway import PassengerGateway
from stucksolver_passenger.server.process import PassengerServer

LIMIT_S = 60.0
"""A request that takes longer than this hangs; a busy machine may need seconds."""
SPARE_FILES = 500


@contextlib.contextmanager
def files_for(count: int):
    """Allow this many more open files; False if the system does not."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    needed = count + SPARE_FILES
    if soft >= needed or soft == resource.RLIM_INFINITY:
        yield True
    elif hard < needed and hard != resource.RLIM_INFINITY:
        yield False
    else:
        resource.setrlimit(resource.RLIMIT_NOFILE, (needed, hard))
        yield True
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@dataclass
class Attacked:
    """A server with one vehicle at its desk."""

    server: PassengerServer
    host: str = "127.0.0.1"
    vehicle: str = "car-1"

    @property
    def stop_path(self) -> str:
        return self.path("stop")

    def path(self, rest: str) -> str:
        return f"/api/vehicles/{self.vehicle}/{rest}"

    @property
    def passenger(self) -> str:
        return self.server.tokens.passenger(self.vehicle)

    @property
    def operator(self) -> str:
        return self.server.tokens.operator()

    @property
    def name(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{host}:{self.server.port}"

    def connect(self, limit_s: float = LIMIT_S) -> socket.socket:
        return socket.create_connection((self.host, self.server.port), timeout=limit_s)

    def ask(self, path: str, token: str | None = None, body: object = None, *, method: str | None = None):
        """The status and the text of one request on a connection of its own."""
        connection = http.client.HTTPConnection(self.host, self.server.port, timeout=LIMIT_S)
        try:
            headers = {} if token is None else {"authorization": f"Bearer {token}"}
            sent = None if body is None else json.dumps(body)
            if sent is not None:
                headers["content-type"] = "application/json"
            connection.request(method or ("GET" if sent is None else "POST"), path, sent, headers)
            answer = connection.getresponse()
            return answer.status, answer.read().decode()
        finally:
            connection.close()

    def stop(self, token: str | None = None) -> int:
        """The status of a press on Stop."""
        return self.ask(self.stop_path, token or self.passenger, {})[0]

    def opened(self, path: str, token: str) -> tuple[int, socket.socket]:
        """A stream that stays open, and its status."""
        connection = self.connect()
        connection.sendall(head("GET", path, self.name, token=token))
        return status_of(connection), connection


def head(method: str, path: str, host: str, *, token: str | None = None, length: int | None = None) -> bytes:
    """The head of a request."""
    lines = [f"{method} {path} HTTP/1.1", f"host: {host}"]
    if token is not None:
        lines.append(f"authorization: Bearer {token}")
    if length is not None:
        lines += ["content-type: application/json", f"content-length: {length}"]
    return ("\r\n".join(lines) + "\r\n\r\n").encode()


def status_of(connection: socket.socket) -> int:
    """The status with which a connection is answered; 0 if it ends without one."""
    line = b""
    with contextlib.suppress(ConnectionError):
        while not line.endswith(b"\n"):
            part = connection.recv(1)
            if not part:
                return 0
            line += part
    return int(line.split()[1]) if line else 0


def ended(connection: socket.socket, limit_s: float = LIMIT_S) -> bool:
    """True if the other side ends the connection within the time."""
    end = time.monotonic() + limit_s
    with contextlib.suppress(ConnectionError):
        while time.monotonic() < end:
            connection.settimeout(max(end - time.monotonic(), 0.01))
            try:
                if not connection.recv(1 << 16):
                    return True
            except TimeoutError:
                return False
        return False
    return True


@contextlib.contextmanager
def attacked(server: PassengerServer, vehicle: str = "car-1", host: str = "127.0.0.1"):
    """A vehicle at the server's desk that takes commands."""
    with PassengerGateway(server.address) as desk:
        world = parked()
        solver = StuckSolver(world.scene, ladder=PASSENGER_ASKED, on_event=desk.ear(vehicle))
        desk.add(vehicle, solver).tick(world.status())
        here = Attacked(server, host, vehicle)
        end = time.monotonic() + LIMIT_S
        while here.ask(f"/api/vehicles/{vehicle}", here.operator)[0] != 200 and time.monotonic() < end:
            time.sleep(0.05)
        yield here
        solver.close()
