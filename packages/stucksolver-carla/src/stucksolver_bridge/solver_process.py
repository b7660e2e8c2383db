"""The solver as a separate process, in a Python that has it installed, connected by an unnamed socket."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
from typing import Any, Sequence

from stucksolver_bridge.message_socket import ANSWER_BYTES, VERSION, Wire, WireError
from stucksolver_bridge.solver_exchange import WAIT_SHARE, Give, SolverExchange, SolverTimeoutError, limit_of

START_LIMIT_S = 120.0
ANSWER_LIMIT_S = 120.0
"""With the clock `lockstep` a step takes as long as the reasoner does."""
END_LIMIT_S = 15.0
"""Longer than the 10 s that the solver allows for finishing its record."""
TICK_S = 0.05
"""CARLA's usual 20 Hz."""
LIVE = "wall"
"""Name of the clock in the settings for a world that does not wait."""
OTHERS_PATHS = ("PYTHONPATH", "PYTHONHOME")
"""Not passed on to the solver: its Python finds its modules elsewhere."""


class SolverError(RuntimeError):
    """The solver could not be started, or kept the world waiting for too long; the message says which."""


class SolverProcess:
    """Starts the solver, asks it on each tick, and ends it. `alive` is False as soon as it fails.

    With the clock `wall` in its settings, no step waits longer than half of `tick_s`.

    Args:
        python: An interpreter 3.10 to 3.12 in which stucksolver is installed.
        hello: The solver's first message (see `stucksolver_carla.sidecar`).
        path: Folder in which that interpreter finds stucksolver, if it is not installed there.
        answer_limit_s: Longest silence of the solver (s).
        tick_s: Length of a tick (s).
        inherited: File descriptors that the new process inherits.

    Raises:
        SolverError: The solver does not start.
        ValueError: An argument is invalid.
    """

    def __init__(
        self,
        python: str,
        hello: dict[str, Any],
        path: str | None = None,
        answer_limit_s: float = ANSWER_LIMIT_S,
        tick_s: float = TICK_S,
        inherited: Sequence[int] = (),
    ) -> None:
        limit_s = limit_of(answer_limit_s, "answer_limit_s")
        self.live = hello.get("settings", {}).get("clock") == LIVE
        wait_s = WAIT_SHARE * limit_of(tick_s, "tick_s") if self.live else None
        ours, theirs = socket.socketpair()
        environment = {name: value for name, value in os.environ.items() if name not in OTHERS_PATHS}
        if path:
            environment["PYTHONPATH"] = path
        command = [python, "-m", "stucksolver_carla.sidecar", "--fd", str(theirs.fileno())]
        kept = (theirs.fileno(), *inherited)
        try:
            self.process = subprocess.Popen(command, env=environment, pass_fds=kept, close_fds=True)
        except OSError as error:
            ours.close()
            raise SolverError(f"cannot start {python!r}: {error}; name a Python 3.10 to 3.12") from error
        finally:
            theirs.close()
        self._wire = Wire(ours, ANSWER_BYTES)
        self._conversation = SolverExchange(self._wire, wait_s, limit_s)
        self.fault: str | None = None
        self._strays_told = False
        self._greet(hello, command[0])

    def _greet(self, hello: dict[str, Any], python: str) -> None:
        try:
            self._wire.send({"hello": {"version": VERSION, **hello}}, START_LIMIT_S)
            answer = self._wire.receive(START_LIMIT_S)
        except WireError as error:
            self.close()
            raise SolverError(f"the solver did not start: {error}; see what {python} printed") from error
        if "error" in answer:
            self.close()
            raise SolverError(str(answer["error"]))
        if answer.get("ready") != VERSION:
            self.close()
            theirs = str(answer.get("ready"))[:20]
            raise SolverError(
                f"the solver speaks version {theirs} of the link's protocol, this bridge version {VERSION}; "
                "install both from the same release"
            )

    @property
    def alive(self) -> bool:
        """True while it answers."""
        return self.fault is None

    @property
    def late_ticks(self) -> int:
        """How many ticks ago the tick of the last answer was; 0 if the world waits."""
        return self._conversation.late_ticks

    def step(self, tick: dict[str, Any], give: Give) -> dict[str, Any] | None:
        """Run one tick.

        Args:
            tick: The facts of this tick, for the solver.
            give: Returns what the solver asks for, by name.

        Returns:
            The solver's answer; None if the solver has failed or, with the clock `wall`, has not answered yet.

        Raises:
            SolverError: The world waits, and the solver has not answered within its limit.
        """
        if self.fault is not None:
            return None
        try:
            answer = self._conversation.step(tick, give)
            self._report_strays()
            return answer
        except SolverTimeoutError as error:
            self._fail(str(error))
            if self.live:
                return None
            remedy = "check what it is doing, or raise answer_limit_s"
            raise SolverError(f"the solver kept the world waiting: {error}; {remedy}") from error
        except WireError as error:
            self._fail(str(error))
            return None

    def close(self) -> None:
        """End the process. It also ends when this end of the socket closes, but its record is then incomplete."""
        if self.fault is None:
            with contextlib.suppress(WireError):
                self._wire.send({"bye": True}, END_LIMIT_S)
        self._wire.close()
        if self.fault is None:
            self.fault = "closed"
        try:
            self.process.wait(END_LIMIT_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def _report_strays(self) -> None:
        """Report once that the solver answered what it was not asked."""
        if self._conversation.strays and not self._strays_told:
            self._strays_told = True
            print("stucksolver: an answer to another tick was dropped; no order is renewed by it", file=sys.stderr)

    def _fail(self, why: str) -> None:
        self.fault = why
        self._wire.close()
        # `close` waits until the process has ended; a control tick does not.
        self.process.kill()
        self.process.poll()
        end = "its last directive ends as proven, then the vehicle drives by itself"
        print(f"stucksolver: the solver has stopped ({why}); {end}", file=sys.stderr, flush=True)
