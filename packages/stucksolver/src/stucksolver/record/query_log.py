"""Stores every query to a reasoner with the surroundings for the guard, as data for search and training.

A record of an intervention omits legitimate waits and stores differences. In this file each line is self-contained.
"""

from __future__ import annotations

from pathlib import Path

from stucksolver.plan import Decision
from stucksolver.privacy.private_files import append
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.record.hash_chain import RecordError
from stucksolver.scene import Scene, Surroundings
from stucksolver.scene.base_model import FrozenModel
from stucksolver.solver import Event
from stucksolver.solver.state_machine.state import Querying
from stucksolver.solver.step_listener import SolverInfo, TransitionStep


class LoggedQuery(FrozenModel):
    """Query that was answered.

    Attributes:
        number: Number of the query in the run, from 1.
        reasoner: Name of the reasoner that answered. It is `rules` also if the ladder's check for a wait answered.
        scene: Scene of the query.
        surroundings: Surroundings for the guard at the same tick; None if there were none.
        decision: Decision in the answer.
    """

    number: int
    reasoner: str
    scene: Scene
    surroundings: Surroundings | None
    decision: Decision


class QueryLog:
    """Step listener that appends a `LoggedQuery` to a file for each answer that was used."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def begin(self, facts: SolverInfo) -> None:
        """Do nothing: the lines do not depend on the solver's setup."""

    def step(self, step: TransitionStep) -> None:
        """Append the query whose answer this step used.

        Raises:
            RecordError: The file cannot be written.
        """
        activity, answer = step.before.activity, step.inputs.answer
        if not isinstance(activity, Querying) or step.after.activity is activity:
            return
        if not isinstance(answer, ReasonerAnswer):
            return
        query = activity.query
        line = LoggedQuery(
            number=query.number,
            reasoner=answer.reasoner,
            scene=query.scene,
            surroundings=query.seen,
            decision=answer.decision,
        )
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            append(self._path, (line.model_dump_json() + "\n").encode())
        except OSError as error:
            raise RecordError(f"cannot write the queries to {self._path}: {error}") from error

    def fault(self, event: Event) -> None:
        """Do nothing: a fault has no query."""


def read_questions(path: Path) -> tuple[LoggedQuery, ...]:
    """Read the queries of a run; none if the file is missing, because there was no query.

    Raises:
        RecordError: A line is not a query.
    """
    if not path.exists():
        return ()
    try:
        return tuple(LoggedQuery.model_validate_json(line) for line in path.read_text("utf-8").splitlines())
    except ValueError as error:
        raise RecordError(f"{path} is not a file of queries: {error}") from error
