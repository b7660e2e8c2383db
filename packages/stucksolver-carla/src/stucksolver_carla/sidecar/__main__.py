"""Runs `python -m stucksolver_carla.sidecar --fd N`. `stucksolver_bridge` starts it and has the other end."""

from __future__ import annotations

import argparse
import signal
import socket
import sys

from stucksolver.record import RecordError
from stucksolver_bridge.message_socket import Wire, WireError
from stucksolver_carla.sidecar.session import SidecarSession


def main() -> int:
    """Serve one stack; return 0 if it sent `bye` and its record, if any, is complete."""
    parser = argparse.ArgumentParser(prog="stucksolver_carla.sidecar", description="Run the solver for a stack.")
    parser.add_argument("--fd", type=int, required=True, help="number of the inherited, connected socket")
    connected = socket.socket(fileno=parser.parse_args().fd)
    # Ctrl-C in the stack's terminal reaches this process too. It must end with the stack, not before it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        SidecarSession(Wire(connected)).run()
    except WireError:
        # The stack has ended without `bye`. The bridge reports the failure, if it still runs.
        return 1
    except RecordError as error:
        print(f"stucksolver: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
