"""The student: a small network of our own that reasons over scenes in milliseconds, on the CPU."""

from __future__ import annotations

from pathlib import Path

from stucksolver.reasoners.registry import Kind, ReasonerNameError
from stucksolver_language.student.network import DATA, WeightsError
from stucksolver_language.student.student_reasoner import Choice, DistilledReasoner


def make_distilled(rest: str, exchanges: Path | None = None) -> DistilledReasoner:
    """Create the student with the weights of a folder, or with those that come with the package.

    Raises:
        ReasonerNameError: The weights are missing, or of another version.
    """
    try:
        return DistilledReasoner(Path(rest) if rest else DATA)
    except WeightsError as error:
        raise ReasonerNameError(f"distilled: {error}") from error


KIND = Kind("distilled", "distilled[:FOLDER]", make_distilled)
__all__ = ["KIND", "Choice", "DistilledReasoner", "WeightsError"]
