"""Starts carlette in its own process and waits until it listens. No other module does this."""

from __future__ import annotations

import contextlib
import importlib.metadata
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING

from stucksolver_carla.client_connection import ServerError, SimulatorServer, remote_server

if TYPE_CHECKING:
    import carla

START_LIMIT_S = 60.0
"""Time limit of the start without scenery (s). Ours."""
SCENERY_LIMIT_S = 180.0
"""Time limit of the start with the scenery (s): long if nothing is compiled yet, on a busy machine. Ours."""
CLIENT_TIMEOUT_S = 15.0
"""Time limit of a client's call (s). Ours."""
_ERROR = "carlette: error: "
SERVED = ("0.9.15", "0.9.16")


@contextlib.contextmanager
def carlette_server(
    map_name: str, maps: str | None = None, seed: int = 0, *, scenery: bool = False, stands: bool = False
) -> Iterator[SimulatorServer]:
    """Start a carlette on a free port. It ends on exit, and also if this process ends.

    With `scenery` cameras and LiDARs measure from their first tick on. Without it a route may be half driven before the
    first image, because the scenery is built in parallel to the ticks. With `stands` the world waits for a client's
    first tick. Otherwise the number of ticks before depends on the machine, and lights are in another phase.

    Raises:
        ServerError: It did not start.
    """
    version = _client_version()
    command = [sys.executable, "-m", "carlette", "--port", "0", "--map", map_name, "--seed", str(seed)]
    command += ["--client-version", version]
    if maps:
        command += ["--maps", maps]
    if scenery:
        command.append("--build-scenery")
    if stands:
        command.append("--synchronous")
    process = subprocess.Popen(
        [*command, "--exit-on-stdin-eof"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        yield _listening(process, SCENERY_LIMIT_S if scenery else START_LIMIT_S)
    finally:
        _end(process)


def open_server(
    map_name: str,
    maps: str | None,
    seed: int,
    host: str | None,
    port: int,
    *,
    scenery: bool = False,
    stands: bool = False,
) -> contextlib.AbstractContextManager[SimulatorServer]:
    """Start carlette (see `carlette_server`), or use the server at `host`.

    Raises:
        ServerError: It did not start, or no server listens at `host`.
    """
    if host is not None:
        return contextlib.nullcontext(remote_server(host, port))
    return carlette_server(map_name, maps, seed, scenery=scenery, stands=stands)


def _client_version() -> str:
    """Return the installed client's version, which carlette needs."""
    version = importlib.metadata.version("carla")
    served = next((known for known in SERVED if version.startswith(known)), None)
    if served is None:
        raise ServerError(
            f"unsupported carla client: {version}, carlette serves {' and '.join(SERVED)}. "
            f"Install one with pip install carla=={SERVED[-1]}"
        )
    return served


def set_synchronous(world: carla.World, dt_s: float | None) -> None:
    """Set ticks of `dt_s` on demand. With None the server uses its own clock again."""
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = dt_s is not None, dt_s
    world.apply_settings(settings)


def _listening(process: subprocess.Popen[str], limit_s: float) -> SimulatorServer:
    """Wait for the line with the address."""
    assert process.stdout is not None and process.stderr is not None
    watchdog = threading.Timer(limit_s, process.kill)
    watchdog.start()
    try:
        line = process.stdout.readline()
    finally:
        watchdog.cancel()
    if "listening on " not in line:
        raise ServerError(_why_not(process, limit_s))
    host, _, port = line.split("listening on ", 1)[1].split()[0].rpartition(":")
    threading.Thread(target=_drain, args=(process.stdout,), daemon=True).start()
    threading.Thread(target=_drain, args=(process.stderr,), daemon=True).start()
    return SimulatorServer(host, int(port), process)


def _why_not(process: subprocess.Popen[str], limit_s: float) -> str:
    """Return the reason why the process has ended: its error, else its signal, else its last line."""
    assert process.stderr is not None
    # The carla library writes warnings of its own, also after the error.
    lines = [line for line in process.stderr.read().splitlines() if line.strip() and not line.startswith("WARNING")]
    code = process.wait()
    for line in lines:
        if line.startswith(_ERROR):
            return line.removeprefix(_ERROR)
    if code == -signal.SIGKILL:
        return f"no answer within {limit_s:.0f} s"
    ended = f"by {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
    return lines[-1] if lines else f"the simulator ended {ended} at its start; run `carlette` with the same --map"


def _drain(stream: object) -> None:
    """Read and discard, so that the server never blocks on a full pipe."""
    # The stream is closed when the server ends.
    with contextlib.suppress(ValueError, OSError):
        for _ in stream:  # type: ignore[attr-defined]
            pass


def _end(process: subprocess.Popen[str]) -> None:
    process.terminate()
    try:
        process.wait(timeout=5)
    except subprocess.TimeoutExpired:
        # A server that ignores the request is killed.
        process.kill()
        process.wait()
    for stream in (process.stdin, process.stdout, process.stderr):
        if stream is not None:
            # The stream may already be closed.
            with contextlib.suppress(OSError):
                stream.close()
