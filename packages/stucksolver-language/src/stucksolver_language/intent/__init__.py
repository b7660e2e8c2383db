"""Interprets a passenger's utterances with a small network."""

from __future__ import annotations

from importlib.util import find_spec

from stucksolver.interpreter import Interpreter, NoInterpreter

PACKAGES = ("onnxruntime", "tokenizers")


def interpreter() -> Interpreter:
    """Return the network, which loads at its first utterance, or a `NoInterpreter` that names the missing packages."""
    missing = [name for name in PACKAGES if find_spec(name) is None]
    if missing:
        return NoInterpreter(f"{' and '.join(missing)} not installed; install stucksolver-language again")
    from stucksolver_language.intent.network import NetworkInterpreter

    return NetworkInterpreter()


__all__ = ["interpreter"]
