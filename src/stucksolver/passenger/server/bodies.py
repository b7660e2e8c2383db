"""What is sent to the API."""

from __future__ import annotations

from pydantic import Field

from stucksolver.ladder.moves import Person
from stucksolver.passenger.told import CLIENT_ID
from stucksolver.scene import MAX_WORDS
from stucksolver.scene.model import Model


class Presser(Model):
    """Whoever presses a button. `client`: chosen by each page, to tell apart those who hold the same token."""

    client: str = Field(default="somebody", pattern=CLIENT_ID)


class Words(Presser):
    """Something said."""

    text: str = Field(min_length=1, max_length=MAX_WORDS)


class Reply(Words):
    """An operator's words to a passenger."""


class Answer(Presser):
    """Yes or no. `question_id`: to which question; one that is not open any more is not answered."""

    yes: bool
    question_id: str = Field(min_length=1, max_length=40)


class Me(Model):
    """Who a token belongs to. `vehicle`: the one to show first; `vehicles`: names by id."""

    role: Person
    vehicle: str | None
    vehicles: dict[str, str]
