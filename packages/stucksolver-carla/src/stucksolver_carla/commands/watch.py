"""Implements `stucksolver watch`, which observes a vehicle that another program drives."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from pathlib import Path

from stucksolver.commands.arguments import PERCEPTIONS, above_zero, add_json, add_perception, port, print_json
from stucksolver.commands.errors import UsageError
from stucksolver.commands.ladder import chosen_ladder
from stucksolver.record import RecordError

UPDATE_PERIOD_S = 0.5
"""Minimum time between two updates of the progress line (s). Ours."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument("--host", default="127.0.0.1", help="address of the server")
    parser.add_argument("--port", type=port, default=2000, help="port of the server")
    parser.add_argument("--role", default="hero", help="role name of the vehicle")
    add_perception(parser)
    parser.add_argument("--out", type=Path, help="folder for the records (default: no records)")
    parser.add_argument("--ladder", default="default", help="ladder: a profile or a file")
    parser.add_argument("--seconds", type=above_zero, help="end after this much wall time (default: until Ctrl-C)")
    add_json(parser, '{"interventions": number of solver interventions, "records": [paths]}')


def run(options: argparse.Namespace) -> int:
    """Observe until the time is up or Ctrl-C, and return 0.

    Raises `UsageError`, also if a record cannot be completed.
    """
    from stucksolver.atomic_files import OutputError, require_writable
    from stucksolver_carla.client_connection import ServerError, connect, remote_server
    from stucksolver_carla.map_trial import require_readable_map
    from stucksolver_carla.observer import VehicleNotFoundError, VehicleObserver

    ladder = chosen_ladder(options.ladder)
    try:
        if options.out is not None:
            require_writable(options.out)
        server = remote_server(options.host, options.port)
        client = connect(server, 10.0)
        require_readable_map(server, 10.0)
        sensors = options.perception != PERCEPTIONS[0]
        observer = VehicleObserver(client.get_world(), options.role, ladder, options.out, lambda event: None, sensors)
    except (ServerError, VehicleNotFoundError, OutputError) as error:
        raise UsageError(str(error)) from error
    line, until = _ProgressLine(), None if options.seconds is None else time.monotonic() + options.seconds
    try:
        with contextlib.suppress(KeyboardInterrupt):
            while until is None or time.monotonic() < until:
                status = observer.step()
                line.show(f"{status.time_s:8.1f} s  {status.speed_mps:5.1f} m/s  ", observer.state)
    except BaseException as error:
        line.end()
        observer.abort()
        if isinstance(error, VehicleNotFoundError):
            raise UsageError(str(error)) from error
        raise
    line.end()
    try:
        observer.close()
    except RecordError as error:
        raise UsageError(str(error)) from error
    if options.json:
        print_json({"interventions": observer.interventions, "records": list(observer.files)})
        return 0
    print(f"{observer.interventions} interventions", *(f"record: {path}" for path in observer.files), sep="\n")
    return 0


class _ProgressLine:
    """The progress line: updated in place on a terminal; in other outputs a new line for each change of the state."""

    def __init__(self) -> None:
        self._shown_s = 0.0
        self._state = ""
        self._width = 0

    def show(self, values: str, state: str) -> None:
        """Show the values and the state: on a terminal in one line, elsewhere a line at each new state."""
        if not sys.stderr.isatty():
            if state != self._state:
                self._state = state
                print(values + state, file=sys.stderr, flush=True)
            return
        if time.monotonic() - self._shown_s < UPDATE_PERIOD_S:
            return
        self._shown_s = time.monotonic()
        text = (values + state)[:118]
        print("\r" + text.ljust(self._width), end="", file=sys.stderr, flush=True)
        self._width = len(text)

    def end(self) -> None:
        if self._width:
            print(file=sys.stderr)
