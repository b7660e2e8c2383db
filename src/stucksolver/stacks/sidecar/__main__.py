"""`python -m stucksolver.stacks.sidecar --fd N`: started by `stucksolver_bridge`, which holds the other end."""

from __future__ import annotations

import argparse
import signal
import socket
import sys

from stucksolver.record import RecordError
from stucksolver.stacks.sidecar.session import Session
from stucksolver_bridge.wire import Wire, WireError


def main() -> int:
    """Serve one stack; 0 when it said goodbye and its record, if it wanted one, is whole."""
    parser = argparse.ArgumentParser(prog="stucksolver.stacks.sidecar", description="The solver beside a stack.")
    parser.add_argument("--fd", type=int, required=True, help="number of the inherited, connected socket")
    connected = socket.socket(fileno=parser.parse_args().fd)
    # Whoever interrupts the stack's terminal means the stack; we end with it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        Session(Wire(connected)).run()
    except WireError:
        return 1
    except RecordError as error:
        print(f"stucksolver: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
