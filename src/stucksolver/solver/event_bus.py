"""Tells listeners and the witness what happens; one that fails is told of, and not called again."""

from __future__ import annotations

from stucksolver.solver.events import Event, EventKind, Judgement, Listener, Tick, Witness


class EventBus:
    """Whatever a listener does, the control loop goes on."""

    def __init__(self, listener: Listener | None, witness: Witness | None) -> None:
        self._listener = listener
        self._witness = witness

    def tell(self, one: Event | Judgement | Tick) -> None:
        """Judgements and ticks are for the witness only, who is told first."""
        if self._witness is not None:
            try:
                _to_witness(self._witness, one)
            except Exception as error:  # noqa: BLE001 - a full disk or a broken witness must not stop the car
                self._witness = None
                self._fault(one.time_s, f"the record ends here: {error}")
        if self._listener is not None and isinstance(one, Event):
            try:
                self._listener(one)
            except Exception as error:  # noqa: BLE001
                self._listener = None
                self._fault(one.time_s, f"a listener failed and is not called again: {error!r}")

    def _fault(self, time_s: float, text: str) -> None:
        self.tell(Event(time_s=time_s, kind=EventKind.FAULT, text=text))


def _to_witness(witness: Witness, one: Event | Judgement | Tick) -> None:
    if isinstance(one, Event):
        witness.event(one)
    elif isinstance(one, Judgement):
        witness.judgement(one)
    else:
        witness.tick(one)
