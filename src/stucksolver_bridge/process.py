"""The solver as a process of its own, on a Python that has it, at the other end of a socket without a name."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
from typing import Any, Callable

from stucksolver_bridge.wire import VERSION, Wire, WireError

START_LIMIT_S = 120.0
ANSWER_LIMIT_S = 120.0
"""With the clock `lockstep` a step takes as long as the reasoner does."""
END_LIMIT_S = 15.0
"""Longer than the 10 s that the solver gives its record."""
OTHERS_PATHS = ("PYTHONPATH", "PYTHONHOME")
"""Where this process finds its modules is not where another Python finds its own."""


class SolverError(RuntimeError):
    """The solver could not be started; the message is its own."""


class SolverProcess:
    """Starts the solver, asks it each tick, and ends it. `alive` is False from the moment on at which it fails.

    `python`: an interpreter 3.10 to 3.12 in which stucksolver is installed. `hello`: what the solver is told first (see
    `stucksolver.stacks.sidecar`). Raises `SolverError`.
    """

    def __init__(self, python: str, hello: dict[str, Any], path: str | None = None) -> None:
        ours, theirs = socket.socketpair()
        environment = {name: value for name, value in os.environ.items() if name not in OTHERS_PATHS}
        if path:
            environment["PYTHONPATH"] = path
        command = [python, "-m", "stucksolver.stacks.sidecar", "--fd", str(theirs.fileno())]
        try:
            self.process = subprocess.Popen(command, env=environment, pass_fds=(theirs.fileno(),), close_fds=True)
        except OSError as error:
            raise SolverError(f"cannot start {python!r}: {error}; name a Python 3.10 to 3.12") from error
        finally:
            theirs.close()
        self._wire = Wire(ours)
        self.fault: str | None = None
        try:
            self._wire.send({"hello": {"version": VERSION, **hello}})
            answer = self._wire.receive(START_LIMIT_S)
        except WireError as error:
            self.close()
            raise SolverError(f"the solver did not start: {error}; see what {command[0]} printed") from error
        if "error" in answer:
            self.close()
            raise SolverError(str(answer["error"]))

    @property
    def alive(self) -> bool:
        return self.fault is None

    def step(self, tick: dict[str, Any], give: Callable[[str], Any]) -> dict[str, Any] | None:
        """One tick: its answer, or None where the solver is dead. `give` returns what it asks for by name."""
        if self.fault is not None:
            return None
        try:
            self._wire.send({"tick": tick})
            while True:
                answer = self._wire.receive(ANSWER_LIMIT_S)
                if "need" not in answer:
                    break
                self._wire.send({"given": give(str(answer["need"]))})
            if "error" in answer:
                raise WireError(str(answer["error"]))
        except WireError as error:
            self._fail(str(error))
            return None
        return answer

    def close(self) -> None:
        """End it. It ends by itself too when this end of the socket closes, but then its record breaks off."""
        if self.fault is None:
            with contextlib.suppress(WireError):
                self._wire.send({"bye": True})
        self._wire.close()
        if self.fault is None:
            self.fault = "closed"
        try:
            self.process.wait(END_LIMIT_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def _fail(self, why: str) -> None:
        self.fault = why
        self._wire.close()
        self.process.kill()
        self.process.wait()
        print(f"stucksolver: the solver is gone ({why}); the vehicle drives by itself", file=sys.stderr, flush=True)
