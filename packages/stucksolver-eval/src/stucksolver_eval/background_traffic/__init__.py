"""Background traffic around the hero, and the hooks with which scenarios control it."""

from stucksolver_eval.background_traffic.background_activity import Background

__all__ = ["Background"]
