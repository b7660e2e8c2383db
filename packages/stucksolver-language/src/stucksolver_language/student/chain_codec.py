"""The student's answer as codes: the chain S1 to S3 in at most 60 tokens, from which the prose follows.

`chain/1 S1 c:red:yes o12:obstructing S2 no no no yes cause:static_obstacle S3 drive_over object_id=12 speed_mps=2`
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote, unquote

from pydantic import ValidationError

from stucksolver.plan import CauseCode, Intent, RecoveryPlan, WaitReason
from stucksolver.scene import GuidanceIntent

VERSION = 1
"""Version of the text."""
HEAD = "chain/"
FORMAT = f"distilled-{VERSION}"
"""The name under which recorded answers are parsed again."""
MOST_TOKENS = 60
"""Longest answer (tokens, separated by spaces). Ours."""
MOST_CONTROLS, MOST_PARTICIPANTS = 3, 6
"""Maximum number of controls and of participants in a chain. Ours."""


class ChainError(ValueError):
    """The text is not a chain of this version. The message says what is wrong."""


@dataclass(frozen=True)
class ReasoningChain:
    """The typed answer.

    Attributes:
        controls: Numbers of the scene's controls that matter.
        participants: Ids of the objects that matter, with their intents, nearest first.
        asked: Intent of the passenger; None without an utterance.
        immobilized: The conclusion of step 2.
        cause: Cause of the immobilization, or None.
        wait: Reason why waiting is right, or None.
        ends: Probability that the wait ends without a plan within 10 s, and within 40 s.
        plan: The decision; None to do nothing.
    """

    controls: tuple[int, ...]
    participants: tuple[tuple[str, Intent], ...]
    asked: GuidanceIntent | None
    immobilized: bool
    cause: CauseCode | None
    wait: WaitReason | None
    ends: tuple[float, float]
    plan: RecoveryPlan | None


def write_chain(chain: ReasoningChain) -> str:
    """Return a chain as text.

    Raises:
        ChainError: It takes more than `MOST_TOKENS` tokens: the plan is too long.
    """
    tokens = [f"{HEAD}{VERSION}", "S1", *(f"c{number}" for number in chain.controls)]
    tokens += [f"o{quote(name, safe='')}:{intent.value}" for name, intent in chain.participants]
    tokens += ["S2", "stuck" if chain.immobilized else "free"]
    tokens += [
        f"{key}:{value.value}"
        for key, value in (("asked", chain.asked), ("cause", chain.cause), ("wait", chain.wait))
        if value is not None
    ]
    tokens += [f"ends:{chain.ends[0]:.2f}:{chain.ends[1]:.2f}", "S3"]
    tokens += ["-"] if chain.plan is None else _plan_tokens(chain.plan)
    if len(tokens) > MOST_TOKENS:
        raise ChainError(f"the answer takes {len(tokens)} tokens, more than {MOST_TOKENS}")
    return " ".join(tokens)


def read_chain(text: str) -> ReasoningChain:
    """Return the chain of a text: `read_chain(write_chain(chain)) == chain`, except for rounded probabilities.

    Raises:
        ChainError: It is not a chain of this version.
    """
    tokens = text.split()
    if not tokens or tokens[0] != f"{HEAD}{VERSION}":
        raise ChainError(f"the answer begins with {text[:20]!r}, not with {HEAD}{VERSION}")
    try:
        item, two, three = (tokens.index(step) for step in ("S1", "S2", "S3"))
        observed, thought, done = tokens[item + 1 : two], tokens[two + 1 : three], tokens[three + 1 :]
        fields = dict(token.split(":", 1) for token in thought[1:])
        soon, late = fields["ends"].split(":")
        return ReasoningChain(
            controls=tuple(int(token[1:]) for token in observed if token[0] == "c"),
            participants=tuple(_participant(token) for token in observed if token[0] == "o"),
            asked=GuidanceIntent(fields["asked"]) if "asked" in fields else None,
            immobilized={"stuck": True, "free": False}[thought[0]],
            cause=CauseCode(fields["cause"]) if "cause" in fields else None,
            wait=WaitReason(fields["wait"]) if "wait" in fields else None,
            ends=(float(soon), float(late)),
            plan=None if done == ["-"] else _plan(done),
        )
    except ValidationError as error:
        raise ChainError(f"the plan is not valid: {error.errors()[0]['msg']}") from error
    except (ValueError, KeyError, IndexError) as error:
        raise ChainError(f"the answer is not a chain: {error}") from error


def _participant(token: str) -> tuple[str, Intent]:
    name, _, intent = token[1:].rpartition(":")
    return unquote(name), Intent(intent)


def _plan_tokens(plan: RecoveryPlan) -> Iterator[str]:
    for behavior in plan.behaviors:
        yield behavior.name
        for key, value in behavior:
            if key != "name" and value is not None:
                yield f"{key}={quote(value, safe='') if isinstance(value, str) else value}"
    if plan.replan_route:
        yield "replan_route"
    if plan.route_start is not None:
        yield f"@{quote(plan.route_start, safe='')}"


def _plan(tokens: list[str]) -> RecoveryPlan:
    behaviors: list[dict[str, Any]] = []
    whole: dict[str, Any] = {"behaviors": behaviors}
    for token in tokens:
        if token.startswith("@"):
            whole["route_start"] = unquote(token[1:])
        elif "=" in token:
            key, _, value = token.partition("=")
            behaviors[-1][key] = unquote(value)
        elif token == "replan_route":
            whole["replan_route"] = True
        else:
            behaviors.append({"name": token})
    return RecoveryPlan.model_validate(whole)
