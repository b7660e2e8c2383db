"""Runs the solver as a separate process, in a Python that has it installed, over an unnamed socket."""

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
"""Time limit for the solver's start (s). It includes imports and the loading of weights. Ours."""
ANSWER_LIMIT_S = 120.0
"""Default time limit for an answer (s). With the clock `lockstep` a step takes as long as the reasoner. Ours."""
END_LIMIT_S = 15.0
"""Time limit for the solver's end (s). It is longer than the 10 s that the solver allows for finishing its record."""
TICK_S = 0.05
"""Length of a tick (s): CARLA's usual 20 Hz."""
LIVE = "wall"
"""Name of the clock in the settings for a world that does not wait."""
UNSHARED_VARIABLES = ("PYTHONPATH", "PYTHONHOME")
"""Environment variables that are not passed on to the solver, because its Python has other module folders."""


class SolverError(RuntimeError):
    """The solver did not start, or exceeded its time limit while the world waited; the message gives the reason."""


class SolverProcess:
    """The solver's process: start, one exchange per tick, end. `alive` is False after the first failure.

    With the clock `wall` in its settings, no step waits longer than half of `tick_s`.

    Args:
        python: An interpreter 3.10 to 3.12 in which stucksolver is installed.
        hello: The solver's first message (see `stucksolver_carla.sidecar`).
        path: Folder in which that interpreter finds stucksolver, if it is not installed there.
        answer_limit_s: Longest time without an answer of the solver (s).
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
        own_end, solver_end = socket.socketpair()
        environment = {name: value for name, value in os.environ.items() if name not in UNSHARED_VARIABLES}
        if path:
            environment["PYTHONPATH"] = path
        command = [python, "-m", "stucksolver_carla.sidecar", "--fd", str(solver_end.fileno())]
        inherited_fds = (solver_end.fileno(), *inherited)
        try:
            self.process = subprocess.Popen(command, env=environment, pass_fds=inherited_fds, close_fds=True)
        except OSError as error:
            own_end.close()
            raise SolverError(f"cannot start {python!r}: {error}; name a Python 3.10 to 3.12") from error
        finally:
            # This process must not hold the solver's end. Otherwise it would not notice when the solver ends.
            solver_end.close()
        self._wire = Wire(own_end, ANSWER_BYTES)
        self._exchange = SolverExchange(self._wire, wait_s, limit_s)
        self.fault: str | None = None
        self._strays_reported = False
        self._greet(hello, command[0])

    def _greet(self, hello: dict[str, Any], python: str) -> None:
        try:
            self._wire.send({"hello": {"version": VERSION, **hello}}, START_LIMIT_S)
            answer = self._wire.receive(START_LIMIT_S)
        except WireError as error:
            self.close()
            raise SolverError(f"the solver did not start: {error}; see the output of {python}") from error
        if "error" in answer:
            self.close()
            raise SolverError(str(answer["error"]))
        if answer.get("ready") != VERSION:
            self.close()
            solver_version = str(answer.get("ready"))[:20]
            raise SolverError(
                f"the solver uses protocol version {solver_version}, this bridge uses version {VERSION}; "
                "install both from the same release"
            )

    @property
    def alive(self) -> bool:
        """True while the solver has not failed and is not closed."""
        return self.fault is None

    @property
    def late_ticks(self) -> int:
        """Ticks between the tick of the last answer and the tick on which it came; 0 if the world waits."""
        return self._exchange.late_ticks

    def step(self, tick: dict[str, Any], give: Give) -> dict[str, Any] | None:
        """Run one tick.

        Args:
            tick: The data of this tick, for the solver.
            give: Returns the data that the solver requests, by name.

        Returns:
            The solver's answer; None if the solver has failed or, with the clock `wall`, if no answer has come yet.

        Raises:
            SolverError: The world waits, and no answer has come within the limit.
        """
        if self.fault is not None:
            return None
        try:
            answer = self._exchange.step(tick, give)
            self._report_strays()
            return answer
        except SolverTimeoutError as error:
            self._fail(str(error))
            if self.live:
                return None
            remedy = "check its output, or raise answer_limit_s"
            raise SolverError(f"the solver kept the world waiting: {error}; {remedy}") from error
        except WireError as error:
            # The driver can continue without the solver, so no error is raised: `fault` has the reason.
            self._fail(str(error))
            return None

    def close(self) -> None:
        """End the process. It also ends when this end of the socket closes, but its record is then incomplete."""
        if self.fault is None:
            # The process may have ended already. It is waited for below in any case.
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
        """Report the first message without a matching tick."""
        if self._exchange.strays and not self._strays_reported:
            self._strays_reported = True
            print("stucksolver: an answer to another tick was dropped; it renews no directive", file=sys.stderr)

    def _fail(self, reason: str) -> None:
        self.fault = reason
        self._wire.close()
        # `close` waits until the process has ended; a control tick must not wait.
        self.process.kill()
        self.process.poll()
        end = "the fallback of its last directive is performed, then the vehicle drives by itself"
        print(f"stucksolver: the solver has stopped ({reason}); {end}", file=sys.stderr, flush=True)
