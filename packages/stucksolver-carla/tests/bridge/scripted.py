"""A solver's process that says what a test has written down, and then falls silent, dies, trickles or babbles."""

from __future__ import annotations

import json
import stat
import sys
import time
from pathlib import Path

import stucksolver_bridge


def scripted(folder: Path, answers: list, end: str | list) -> str:
    """A file to start as `python`: one answer for each tick, and then `end`, a name of `ENDS`.

    An `end` that is a list holds the version that the process says it speaks.
    """
    program = folder / "scripted"
    # It finds the modules that this process has, wherever they are.
    found = [str(Path(__file__).parent), str(Path(stucksolver_bridge.__file__).parents[1])]
    program.write_text(f"#!{sys.executable}\nimport sys\nsys.path[:0] = {found!r}\n", encoding="utf-8")
    with program.open("a") as file:
        file.write(f"import scripted\nscripted.serve({json.dumps(json.dumps(answers))}, {end!r})\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return str(program)


def serve(answers: str, end: str | list) -> None:
    import socket

    from stucksolver_bridge.message_socket import VERSION, Wire, WireError

    connected = socket.socket(fileno=int(sys.argv[sys.argv.index("--fd") + 1]))
    wire = Wire(connected)
    try:
        wire.receive()
        wire.send({"ready": VERSION if not isinstance(end, list) else end[0]})
        for answer in json.loads(answers):
            wire.send({**answer, "number": wire.receive()["number"]})
        ENDS[end](connected, wire, wire.receive()["number"])
    except WireError:
        return


def _silent(connected, wire, number) -> None:
    time.sleep(600.0)


def _dies(connected, wire, number) -> None:
    sys.exit(3)


def _trickles(connected, wire, number) -> None:
    connected.setblocking(True)
    connected.sendall(b"\x00\x00\x10\x00")
    while True:
        connected.sendall(b"x")
        time.sleep(0.05)


def _babbles(connected, wire, number) -> None:
    connected.setblocking(True)
    connected.sendall(b"\x00\x00\x00\x08babble!!")
    time.sleep(600.0)


def _says_the_same(connected, wire, number) -> None:
    while True:
        wire.send({"number": number})
        number = wire.receive()["number"]


def _floods(connected, wire, number) -> None:
    """A thread goes on answering although the solver sleeps: without a number."""
    _pours(wire, lambda k: {})


def _floods_old(connected, wire, number) -> None:
    """The last answer, over and over: the solver sleeps in the next tick."""
    _pours(wire, lambda k: {"number": number - 1})


def _floods_any(connected, wire, number) -> None:
    """Numbers that are none, and such as look like the right one."""
    odd = [None, True, float(number), str(number), [number], {"number": number}, -number, number + 10**30, "", 0]
    _pours(wire, lambda k: {"number": odd[k % len(odd)]})


def _trickles_old(connected, wire, number) -> None:
    """One old answer a tick, for ever."""
    while True:
        wire.send({"number": number - 1})
        wire.receive()


def _doubles(connected, wire, number) -> None:
    """Each answer comes three times, and then none."""
    for _ in range(30):
        for _ in range(3):
            wire.send({"number": number})
        number = wire.receive()["number"]
    time.sleep(600.0)


def _reorders(connected, wire, number) -> None:
    """The answers to the next ticks come first, the right one never."""
    while True:
        for ahead in (3, 1, 2):
            wire.send({"number": number + ahead})
        wire.receive()
        number += 1
        time.sleep(0.2)


def _pours(wire, message) -> None:
    for k in range(100_000):
        wire.send(message(k))


ENDS = {
    "silent": _silent,
    "dies": _dies,
    "trickles": _trickles,
    "babbles": _babbles,
    "goes on": _says_the_same,
    "floods": _floods,
    "floods old": _floods_old,
    "floods any": _floods_any,
    "trickles old": _trickles_old,
    "doubles": _doubles,
    "reorders": _reorders,
}
