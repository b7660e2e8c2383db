"""Public interface of the solver: `StuckSolver`, its events and its questions."""

from stucksolver.solver.events import Event, EventKind, ExecutionTick, PlanReview
from stucksolver.solver.notices import Notice, StandstillReason
from stucksolver.solver.questions import Question, QuestionError, QuestionKind
from stucksolver.solver.recovery_watch import RecoveryWatch
from stucksolver.solver.solver import MakeScene, StuckSolver
from stucksolver.solver.step_listener import StepListener, TransitionStep
from stucksolver.solver.workers.delivery_clock import DeliveryClock, make_clock

__all__ = [
    "DeliveryClock",
    "Event",
    "EventKind",
    "ExecutionTick",
    "MakeScene",
    "Notice",
    "PlanReview",
    "Question",
    "QuestionError",
    "QuestionKind",
    "RecoveryWatch",
    "StandstillReason",
    "StepListener",
    "StuckSolver",
    "TransitionStep",
    "make_clock",
]
