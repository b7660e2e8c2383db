"""`python -m stucksolver.stacks.sidecar --fd N`: started by `stucksolver_bridge`, which holds the other end."""

from __future__ import annotations

import argparse
import contextlib
import signal
import socket

from stucksolver.stacks.sidecar.session import Session
from stucksolver_bridge.wire import Wire, WireError


def main() -> None:
    """Serve one stack until it hangs up."""
    parser = argparse.ArgumentParser(prog="stucksolver.stacks.sidecar", description="The solver beside a stack.")
    parser.add_argument("--fd", type=int, required=True, help="number of the inherited, connected socket")
    connected = socket.socket(fileno=parser.parse_args().fd)
    # Whoever interrupts the stack's terminal means the stack; we end with it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with contextlib.suppress(WireError):
        Session(Wire(connected)).run()


if __name__ == "__main__":
    main()
