"""A solver's process that says what a test has written down, and then falls silent, dies, trickles or babbles."""

from __future__ import annotations

import json
import stat
import sys
import time
from pathlib import Path


def scripted(folder: Path, answers: list, end: str) -> str:
    """A file to start as `python`: one answer for each tick, and then `end`, a name of `ENDS`."""
    program = folder / "scripted"
    program.write_text(f"#!{sys.executable}\nimport sys\nsys.path.insert(0, {str(Path(__file__).parent)!r})\n")
    with program.open("a") as file:
        file.write(f"import scripted\nscripted.serve({json.dumps(json.dumps(answers))}, {end!r})\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return str(program)


def serve(answers: str, end: str) -> None:
    import socket

    from stucksolver_bridge.wire import VERSION, Wire, WireError

    connected = socket.socket(fileno=int(sys.argv[sys.argv.index("--fd") + 1]))
    wire = Wire(connected)
    try:
        wire.receive()
        wire.send({"ready": VERSION})
        for answer in json.loads(answers):
            wire.receive()
            wire.send(answer)
        wire.receive()
        ENDS[end](connected, wire)
    except WireError:
        return


def _silent(connected, wire) -> None:
    time.sleep(600.0)


def _dies(connected, wire) -> None:
    sys.exit(3)


def _trickles(connected, wire) -> None:
    connected.setblocking(True)
    connected.sendall(b"\x00\x00\x10\x00")
    while True:
        connected.sendall(b"x")
        time.sleep(0.05)


def _babbles(connected, wire) -> None:
    connected.setblocking(True)
    connected.sendall(b"\x00\x00\x00\x08babble!!")
    time.sleep(600.0)


def _says_the_same(connected, wire) -> None:
    while True:
        wire.send({})
        wire.receive()


ENDS = {"silent": _silent, "dies": _dies, "trickles": _trickles, "babbles": _babbles, "goes on": _says_the_same}
