"""Creates the user's own reasoner `own:MODULE:CLASS`: imported by name and created without arguments."""

from __future__ import annotations

import importlib
from pathlib import Path

from stucksolver.reasoners.reasoner import Reasoner
from stucksolver.reasoners.registry import ReasonerKind, ReasonerNameError, register


def make_own(rest: str, exchanges: Path | None = None) -> Reasoner:
    """Create a reasoner from the user's class, `package.module:Class`.

    Raises:
        ReasonerNameError: The class cannot be imported or created, or is not a reasoner.
    """
    module, _, name = rest.partition(":")
    if not module or not name:
        raise ReasonerNameError(f"own:{rest}: name a module and a class in it, as own:my_package.mine:MyReasoner")
    try:
        reasoner = getattr(importlib.import_module(module), name)()
    except Exception as error:
        raise ReasonerNameError(f"own:{rest} cannot be created: {type(error).__name__}: {error}") from error
    missing = [part for part in ("name", "decide") if not hasattr(reasoner, part)]
    if missing:
        raise ReasonerNameError(f"own:{rest} is not a reasoner: it has no {' and no '.join(missing)}")
    own: Reasoner = reasoner
    return own


register(ReasonerKind("own", "own:MODULE:CLASS", make_own, sees=lambda rest: True))
