"""The kinds of rung. Adding one is one file and its name in both lists below."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from stucksolver.ladder.rungs.base import Rung
from stucksolver.ladder.rungs.distilled import DistilledRung
from stucksolver.ladder.rungs.model import ModelRung
from stucksolver.ladder.rungs.passenger import PassengerRung
from stucksolver.ladder.rungs.remote import RemoteRung
from stucksolver.ladder.rungs.rules import RulesRung
from stucksolver.ladder.rungs.wait import WaitRung

AnyRung = Annotated[
    WaitRung | RulesRung | DistilledRung | ModelRung | PassengerRung | RemoteRung, Field(discriminator="kind")
]

KINDS: dict[str, type[Rung]] = {
    cls.model_fields["kind"].default: cls
    for cls in (WaitRung, RulesRung, DistilledRung, ModelRung, PassengerRung, RemoteRung)
}
