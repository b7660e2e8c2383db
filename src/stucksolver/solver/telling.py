"""Tells listeners and the witness what happens; one that fails is told of, and not called again."""

from __future__ import annotations

from stucksolver.solver.events import Event, EventKind, Judgement, Listener, Tick, Witness


class Teller:
    """Whatever a listener does, the control loop goes on."""

    def __init__(self, listener: Listener | None, witness: Witness | None) -> None:
        self._listener = listener
        self._witness = witness

    @property
    def watched(self) -> bool:
        """Is there a witness, who wants to know of every tick?"""
        return self._witness is not None

    def event(self, event: Event) -> None:
        if self._witness is not None:
            try:
                self._witness.event(event)
            except Exception as error:  # noqa: BLE001 - a full disk or a broken witness must not stop the car
                self._lost(event.time_s, error)
        if self._listener is not None:
            try:
                self._listener(event)
            except Exception as error:  # noqa: BLE001
                self._listener = None
                self._fault(event.time_s, f"a listener failed and is not called again: {error!r}")

    def judgement(self, judgement: Judgement) -> None:
        if self._witness is not None:
            try:
                self._witness.judgement(judgement)
            except Exception as error:  # noqa: BLE001
                self._lost(judgement.time_s, error)

    def tick(self, tick: Tick) -> None:
        if self._witness is not None:
            try:
                self._witness.tick(tick)
            except Exception as error:  # noqa: BLE001
                self._lost(tick.time_s, error)

    def _lost(self, time_s: float, error: Exception) -> None:
        self._witness = None
        self._fault(time_s, f"the record ends here: {error}")

    def _fault(self, time_s: float, text: str) -> None:
        self.event(Event(time_s=time_s, kind=EventKind.FAULT, text=text))
