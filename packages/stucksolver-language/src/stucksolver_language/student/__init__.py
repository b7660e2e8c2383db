"""The student: a small network that reasons over scenes in milliseconds, on the CPU."""

from __future__ import annotations

from pathlib import Path

from stucksolver.reasoners.registry import ReasonerKind, ReasonerNameError
from stucksolver_language.student.network import DATA, StudentWeightsError
from stucksolver_language.student.student_reasoner import DistilledReasoner, SelectionPolicy


def make_distilled(rest: str, exchanges: Path | None = None) -> DistilledReasoner:
    """Create the student with the weights of a folder, or with those in the package.

    Raises:
        ReasonerNameError: The weights are missing, or of another version.
    """
    try:
        return DistilledReasoner(Path(rest) if rest else DATA)
    except StudentWeightsError as error:
        raise ReasonerNameError(f"distilled: {error}") from error


KIND = ReasonerKind("distilled", "distilled[:FOLDER]", make_distilled)
__all__ = ["KIND", "DistilledReasoner", "SelectionPolicy", "StudentWeightsError"]
