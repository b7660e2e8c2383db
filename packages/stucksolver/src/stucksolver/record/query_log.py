"""Stores every question to a reasoner with the surroundings that the guard saw, as data for search and training.

A record of an intervention omits legitimate waits and stores differences. Here each line is self-contained.
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
    """A question that was answered.

    Attributes:
        number: Its number in the drive, from 1.
        reasoner: Who answered: `rules` also where the ladder's look for a wait answered instead of the reasoner.
        scene: What the reasoner was told.
        surroundings: What the guard saw at the same tick; None if nothing was seen.
        decision: The answer.
    """

    number: int
    reasoner: str
    scene: Scene
    surroundings: Surroundings | None
    decision: Decision


class QueryLog:
    """A witness of the solver that appends an `LoggedQuery` to a file for each answer that was taken."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def begin(self, facts: SolverInfo) -> None:
        """Do nothing: the lines need no facts of the drive."""

    def step(self, step: TransitionStep) -> None:
        """Append the question whose answer this step used.

        Raises:
            RecordError: The file cannot be written.
        """
        asked, answer = step.before.activity, step.inputs.answer
        if not isinstance(asked, Querying) or step.after.activity is asked or not isinstance(answer, ReasonerAnswer):
            return
        query = asked.query
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
            raise RecordError(f"cannot write the questions to {self._path}: {error}") from error

    def fault(self, event: Event) -> None:
        """Do nothing: nothing was asked."""


def read_questions(path: Path) -> tuple[LoggedQuery, ...]:
    """Read the questions of a drive; none if the file is missing, because nothing was asked.

    Raises:
        RecordError: A line is not a question.
    """
    if not path.exists():
        return ()
    try:
        return tuple(LoggedQuery.model_validate_json(line) for line in path.read_text("utf-8").splitlines())
    except ValueError as error:
        raise RecordError(f"{path} is not a file of questions: {error}") from error
