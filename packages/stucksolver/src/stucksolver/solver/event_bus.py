"""Delivers events to listeners and steps to the witness. One that raises is reported and not called again."""

from __future__ import annotations

import logging

from stucksolver.scene.wording import error_text, in_one_line
from stucksolver.solver.events import Event, EventKind, Listener
from stucksolver.solver.step_listener import StepListener, TransitionStep

LOG = logging.getLogger(__name__)


class EventBus:
    """Isolates the control loop from errors in listeners and in the witness. Each fault is also a line of the log."""

    def __init__(self, listener: Listener | None, witness: StepListener | None) -> None:
        self._listener = listener
        self._witness = witness

    def step(self, step: TransitionStep) -> None:
        """Report a step: first to the witness, then to the listeners."""
        if self._witness is not None:
            try:
                self._witness.step(step)
            except Exception as error:  # noqa: BLE001 - a full disk or a broken witness must not stop the car
                self._lose_witness(step.inputs.status.time_s - step.inputs.offset_s, error)
        for item in step.outputs:
            if isinstance(item, Event):
                self._listen(item)

    def fault(self, event: Event) -> None:
        """Report a fault that happened outside a step."""
        if self._witness is not None:
            try:
                self._witness.fault(event)
            except Exception as error:  # noqa: BLE001
                self._lose_witness(event.time_s, error)
        self._listen(event)

    def _listen(self, event: Event) -> None:
        if event.kind is EventKind.FAULT:
            LOG.warning("%s", event.text)
        if self._listener is None:
            return
        try:
            self._listener(event)
        except Exception as error:  # noqa: BLE001
            self._listener = None
            why = f"a listener failed and is not called again: {in_one_line(error)}"
            self.fault(Event(time_s=event.time_s, kind=EventKind.FAULT, text=why))

    def _lose_witness(self, time_s: float, error: Exception) -> None:
        self._witness = None
        self._listen(Event(time_s=time_s, kind=EventKind.FAULT, text=f"the record ends here: {error_text(error)}"))
