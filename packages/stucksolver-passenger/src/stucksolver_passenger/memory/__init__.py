"""A memory of what helped: off by default, only on this machine, and never more than a proposal."""

from stucksolver_passenger.memory.features import SceneFeatures, features_of, similarity
from stucksolver_passenger.memory.memory import Memory
from stucksolver_passenger.memory.memory_reasoner import RememberingReasoner
from stucksolver_passenger.memory.observer import Observer
from stucksolver_passenger.memory.recall import Remembered, recall
from stucksolver_passenger.memory.solution import Solution, solution_of
from stucksolver_passenger.memory.store import EpisodeStore, Kept, MemoryFileError
from stucksolver_passenger.memory.success_rate import Rate
from stucksolver_passenger.memory.tried_solution import Ending, Episode

__all__ = [
    "Ending",
    "Episode",
    "EpisodeStore",
    "Kept",
    "Memory",
    "MemoryFileError",
    "Observer",
    "Rate",
    "Remembered",
    "RememberingReasoner",
    "SceneFeatures",
    "Solution",
    "features_of",
    "recall",
    "similarity",
    "solution_of",
]
