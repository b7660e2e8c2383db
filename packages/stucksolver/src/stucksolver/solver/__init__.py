"""The public face of the solver: `StuckSolver`, its events and its questions."""

from stucksolver.solver.events import Event, EventKind, Judgement, Tick
from stucksolver.solver.questions import Question, QuestionError, QuestionKind
from stucksolver.solver.recovery_watch import ProgressWatch
from stucksolver.solver.solver import MakeScene, StuckSolver
from stucksolver.solver.step_listener import StepTaken, Witness
from stucksolver.solver.workers.delivery_clock import Clock, make_clock

__all__ = [
    "Clock",
    "Event",
    "EventKind",
    "Judgement",
    "MakeScene",
    "ProgressWatch",
    "Question",
    "QuestionError",
    "QuestionKind",
    "StepTaken",
    "StuckSolver",
    "Tick",
    "Witness",
    "make_clock",
]
