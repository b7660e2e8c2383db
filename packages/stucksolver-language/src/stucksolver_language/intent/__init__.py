"""Interprets a passenger's words with a small network."""

from __future__ import annotations

from importlib.util import find_spec

from stucksolver.interpreter import Interpreter, NoInterpreter

PACKAGES = ("onnxruntime", "tokenizers")


def interpreter() -> Interpreter:
    """Return the network, which loads at its first words, or a `NoInterpreter` that says what is missing."""
    missing = [name for name in PACKAGES if find_spec(name) is None]
    if missing:
        return NoInterpreter(f"{' and '.join(missing)} not installed; install stucksolver-language again")
    from stucksolver_language.intent.network import NetworkInterpreter

    return NetworkInterpreter()


__all__ = ["interpreter"]
