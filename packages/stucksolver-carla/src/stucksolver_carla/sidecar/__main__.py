"""`python -m stucksolver_carla.sidecar --fd N`: started by `stucksolver_bridge`, which holds the other end."""

from __future__ import annotations

import argparse
import signal
import socket
import sys

from stucksolver.record import RecordError
from stucksolver_bridge.message_socket import Wire, WireError
from stucksolver_carla.sidecar.session import SidecarSession


def main() -> int:
    """Serve one stack; return 0 if it said goodbye and its record, if any, is complete."""
    parser = argparse.ArgumentParser(prog="stucksolver_carla.sidecar", description="The solver beside a stack.")
    parser.add_argument("--fd", type=int, required=True, help="number of the inherited, connected socket")
    connected = socket.socket(fileno=parser.parse_args().fd)
    # An interrupt in the stack's terminal is meant for the stack; this process ends with it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        SidecarSession(Wire(connected)).run()
    except WireError:
        return 1
    except RecordError as error:
        print(f"stucksolver: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
