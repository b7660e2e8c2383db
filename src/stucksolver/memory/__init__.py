"""A memory of what helped: off by default, only on this machine, and never more than a proposal."""

from stucksolver.memory.episode import Ending, Episode
from stucksolver.memory.features import SceneFeatures, features_of, similarity
from stucksolver.memory.memory import Memory
from stucksolver.memory.observer import Observer
from stucksolver.memory.rate import Rate
from stucksolver.memory.reasoner import RememberingReasoner
from stucksolver.memory.recall import Remembered, recall
from stucksolver.memory.solution import Solution, solution_of
from stucksolver.memory.store import EpisodeStore, Kept, MemoryFileError

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
