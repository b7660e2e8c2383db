"""The traffic around the hero, and the hooks by which scenarios shape it."""

from stucksolver_eval.background.background import Background

__all__ = ["Background"]
