"""Delivers events to the event listener and steps to the step listener. A failing listener is reported and removed."""

from __future__ import annotations

import logging

from stucksolver.scene.wording import error_text, in_one_line
from stucksolver.solver.events import Event, EventKind, Listener
from stucksolver.solver.side_texts import swapped_event
from stucksolver.solver.step_listener import StepListener, TransitionStep

LOG = logging.getLogger(__name__)


class EventBus:
    """Bus that isolates the control loop from errors in its listeners. Each fault is also written to the log."""

    def __init__(self, listener: Listener | None, step_listener: StepListener | None) -> None:
        self._listener = listener
        self._step_listener = step_listener
        self.mirrored = False
        """True if the surroundings are mirrored for left-hand traffic. Events for people then name the other side."""

    def step(self, step: TransitionStep) -> None:
        """Report a step: first to the step listener, so that the record has it even if the event listener fails."""
        if self._step_listener is not None:
            try:
                self._step_listener.step(step)
            except Exception as error:  # noqa: BLE001 - a full disk or a broken listener must not stop the car
                self._remove_step_listener(step.inputs.status.time_s - step.inputs.offset_s, error)
        for item in step.outputs:
            if isinstance(item, Event):
                self._listen(item)

    def fault(self, event: Event) -> None:
        """Report a fault that happened outside a step."""
        if self._step_listener is not None:
            try:
                self._step_listener.fault(event)
            except Exception as error:  # noqa: BLE001 - as above
                self._remove_step_listener(event.time_s, error)
        self._listen(event)

    def _listen(self, event: Event) -> None:
        if event.kind is EventKind.FAULT:
            LOG.warning("%s", event.text)
        if self._listener is None:
            return
        try:
            self._listener(swapped_event(event) if self.mirrored else event)
        except Exception as error:  # noqa: BLE001 - as above
            # The listener is removed before the fault is reported, or the report would call it again.
            self._listener = None
            why = f"a listener failed and is not called again: {in_one_line(error)}"
            self.fault(Event(time_s=event.time_s, kind=EventKind.FAULT, text=why))

    def _remove_step_listener(self, time_s: float, error: Exception) -> None:
        self._step_listener = None
        self._listen(Event(time_s=time_s, kind=EventKind.FAULT, text=f"the record ends here: {error_text(error)}"))
