"""Background traffic around the hero, and the hooks with which scenarios control it."""

from stucksolver_eval.background.background import Background

__all__ = ["Background"]
