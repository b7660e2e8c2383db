"""The object a stack owns."""

from stucksolver.solver.clock import Clock, make_clock
from stucksolver.solver.events import Event, EventKind
from stucksolver.solver.progress import ProgressWatch
from stucksolver.solver.solver import SolverSettings, StuckSolver

__all__ = ["Clock", "Event", "EventKind", "ProgressWatch", "SolverSettings", "StuckSolver", "make_clock"]
