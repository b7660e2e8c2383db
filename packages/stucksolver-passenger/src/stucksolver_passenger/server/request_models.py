"""The bodies of requests to the API."""

from __future__ import annotations

from pydantic import Field

from stucksolver.ladder.rung_actions import Person
from stucksolver.scene import MAX_WORDS
from stucksolver.scene.base_model import FrozenModel
from stucksolver_passenger.api_types import CLIENT_ID


class ClientRequest(FrozenModel):
    """The sender of a request. Each page chooses its `client`, to distinguish holders of the same token."""

    client: str = Field(default="somebody", pattern=CLIENT_ID)


class UtteranceRequest(ClientRequest):
    """An utterance."""

    text: str = Field(min_length=1, max_length=MAX_WORDS)


class OperatorMessageRequest(UtteranceRequest):
    """An operator's message to a passenger."""


class YesNoRequest(ClientRequest):
    """Yes or no. `question_id` names the question; a closed question is not answered."""

    yes: bool
    question_id: str = Field(min_length=1, max_length=40)


class TokenInfo(FrozenModel):
    """Holder of a token. `vehicle` is the one to display first; `vehicles` has names by id."""

    role: Person
    vehicle: str | None
    vehicles: dict[str, str]
