"""Claims that people make about the world without asking for anything: what each changes, and for how long.

A claim never replaces what is seen: no claim makes a road clear, a queue an obstruction or an unknown object soft.
docs/words.md lists the effect of each claim.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from stucksolver.guard import NOBODY, Approvals
from stucksolver.plan.behaviors import Check, names_with
from stucksolver.scene import Claim, GuidanceIntent, Interpretation
from stucksolver.solver.state_machine.pending_transition import PendingTransition
from stucksolver.solver.state_machine.state import AwaitingApproval, AwaitingGap, Executing, Monitoring, State

TAKES_BACK: Mapping[Claim, frozenset[Claim]] = MappingProxyType(
    {
        Claim.RETURNING_SOON: frozenset({Claim.LONG_STAY}),
        Claim.LONG_STAY: frozenset({Claim.RETURNING_SOON}),
        Claim.NOT_CLEAR: frozenset({Claim.WAVED_THROUGH, Claim.CLEAR}),
        Claim.HURRY: frozenset({Claim.NO_HURRY}),
        Claim.NO_HURRY: frozenset({Claim.HURRY}),
    }
)
"""The claims that a newer claim replaces."""
CONFIRMS: Mapping[Claim, str] = MappingProxyType(
    {Claim.SOFT_OBJECT: "soft_object", Claim.LONG_STAY: "long_stay"},
)
"""The claims that the guard uses, by its own names for them (`guard.policy.approvals.CLAIMS`)."""


def add_claim(turn: PendingTransition, reading: Interpretation) -> bool:
    """Accept a claim as far as claims are believed.

    A denied claim ("that is not a bag") takes back an earlier one, and gives nothing. Words that say that something
    must not be driven over bar it until it is behind, whatever is claimed later. A claim in words that ask for
    something unlawful has no effect.

    Returns:
        False if the words claim nothing.
    """
    _take_back(turn, reading)
    if not reading.claims or reading.negated or reading.intent is GuidanceIntent.UNLAWFUL:
        return False
    until_s = turn.now_s + turn.setup.ladder.words.claims_s
    gone = frozenset(old for new in reading.claims for old in TAKES_BACK.get(new, ()))
    kept = {claim: until for claim, until in turn.state.claims.items() if claim not in gone}
    turn.state = replace(turn.state, claims=MappingProxyType({**kept, **dict.fromkeys(reading.claims, until_s)}))
    _set_patience(turn, reading)
    if Claim.RETURNING_SOON in reading.claims:
        _wait_for_who_returns(turn)
    elif reading.intent is GuidanceIntent.NONE and isinstance(turn.state.activity, Monitoring):
        turn.pause(turn.now_s)  # look again now with the new claim
    return True


def _take_back(turn: PendingTransition, reading: Interpretation) -> None:
    """Drop what the words deny, and bar driving over what they warn of."""
    if not turn.state.claims.keys().isdisjoint(reading.denied):
        kept = {claim: until for claim, until in turn.state.claims.items() if claim not in reading.denied}
        turn.state = replace(turn.state, claims=MappingProxyType(kept))
    if reading.danger:
        turn.state = replace(turn.state, barred_m=turn.status.progress_m)
        running = turn.state.activity
        if isinstance(running, Executing) and any(Check.PASSABLE in b.checks for b in running.execution.plan.behaviors):
            turn.state = replace(
                turn.state, activity=replace(running, execution=running.execution.withdrawn(), withdrawn=True)
            )


def active_claims(state: State, now_s: float) -> tuple[Claim, ...]:
    """The claims that are believed now."""
    return tuple(claim for claim, until_s in state.claims.items() if now_s <= until_s)


def as_guard_input(state: State, now_s: float) -> Approvals:
    """What the passenger has confirmed, in the form that the guard reads."""
    names = frozenset(CONFIRMS[claim] for claim in active_claims(state, now_s) if claim in CONFIRMS)
    barred = names_with(Check.PASSABLE) if state.barred_m is not None else frozenset()
    return Approvals(passenger=names, barred=barred) if names or barred else NOBODY


def _set_patience(turn: PendingTransition, reading: Interpretation) -> None:
    """A passenger who is late waits less long, one who has time waits longer, within the ladder's bounds."""
    asked = turn.setup.ladder.words.patience
    for claim, factor in ((Claim.HURRY, asked.hurry), (Claim.NO_HURRY, asked.no_hurry)):
        if claim in reading.claims:
            turn.state = replace(turn.state, escalation=replace(turn.state.escalation, patience=factor))


def _wait_for_who_returns(turn: PendingTransition) -> None:
    """Begin nothing while the words count. A running plan continues, since only a call to stop ends it."""
    state = turn.state
    if isinstance(state.activity, Executing):
        return
    turn.drop_query()
    if isinstance(state.activity, AwaitingApproval):
        turn.withdraw_question()
    if isinstance(state.activity, AwaitingGap):
        turn.state = replace(turn.state, activity=Monitoring())
    until_s = max(state.escalation.quiet_until_s, turn.now_s + turn.setup.ladder.words.expire_s)
    turn.state = replace(turn.state, words=None, escalation=replace(turn.state.escalation, quiet_until_s=until_s))
