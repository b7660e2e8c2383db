"""A memory of successful solutions. It is off by default, stays on this machine, and only makes proposals."""

from stucksolver_passenger.memory.features import SceneFeatures, features_of, similarity
from stucksolver_passenger.memory.memory import Memory
from stucksolver_passenger.memory.memory_reasoner import MemoryReasoner
from stucksolver_passenger.memory.observer import OutcomeObserver
from stucksolver_passenger.memory.recall import RecalledSolution, recall
from stucksolver_passenger.memory.solution import Solution, solution_of
from stucksolver_passenger.memory.store import MemoryFileError, SolutionStore, StoredSolution
from stucksolver_passenger.memory.success_rate import SuccessRate
from stucksolver_passenger.memory.tried_solution import SolutionOutcome, TriedSolution

__all__ = [
    "Memory",
    "MemoryFileError",
    "MemoryReasoner",
    "OutcomeObserver",
    "RecalledSolution",
    "SceneFeatures",
    "Solution",
    "SolutionOutcome",
    "SolutionStore",
    "StoredSolution",
    "SuccessRate",
    "TriedSolution",
    "features_of",
    "recall",
    "similarity",
    "solution_of",
]
