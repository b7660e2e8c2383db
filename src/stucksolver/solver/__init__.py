"""The object a stack owns."""

from stucksolver.solver.events import Event, EventKind, Judgement, Tick, Witness
from stucksolver.solver.progress import ProgressWatch
from stucksolver.solver.questions import Question, QuestionError, QuestionKind
from stucksolver.solver.solver import StuckSolver
from stucksolver.solver.workers.clock import Clock, make_clock

__all__ = [
    "Clock",
    "Event",
    "EventKind",
    "Judgement",
    "ProgressWatch",
    "Question",
    "QuestionError",
    "QuestionKind",
    "StuckSolver",
    "Tick",
    "Witness",
    "make_clock",
]
