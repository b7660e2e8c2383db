"""Reads the map of a running server in a child process first, because the client's library may crash on it."""

from __future__ import annotations

import signal
import subprocess
import sys

from stucksolver_carla.client_connection import ServerError, SimulatorServer

LIMIT_S = 60.0
"""Time limit of the child (s). Ours; a town is read within 2 s on a busy core."""
_READ = """
import sys, carla
client = carla.Client(sys.argv[1], int(sys.argv[2]))
client.set_timeout(float(sys.argv[3]))
client.get_world().get_map()
"""


def require_readable_map(server: SimulatorServer, timeout_s: float) -> None:
    """Check that this process can read the server's map, where a crash of the client's library would end it.

    A carlette that was started here has tried its map itself. `timeout_s` is the time limit of each of the client's
    calls.

    Raises:
        ServerError: The library crashes on the map, rejects it, or takes too long.
    """
    if server.process is not None:
        return
    command = [sys.executable, "-c", _READ, server.host, str(server.port), str(timeout_s)]
    where = f"the map of the server at {server.host}:{server.port}"
    try:
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        raise ServerError(f"{where} is not read within {LIMIT_S:.0f} s; load a smaller map there") from None
    if done.returncode < 0:
        name = signal.Signals(-done.returncode).name
        raise ServerError(
            f"{where} crashes the carla client ({name}); `carlette --map FILE` names the fault of its .xodr file"
        )
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no reason given"])[-1]
        raise ServerError(f"{where} cannot be read: {last}; load another map there")
