"""Interprets a passenger's words with a small network."""

from __future__ import annotations

from importlib.util import find_spec

from stucksolver.interpreter import NoReader, WordsReader

PACKAGES = ("onnxruntime", "tokenizers")


def interpreter() -> WordsReader:
    """Return the network, which loads at its first words, or a `NoReader` that says what is missing."""
    missing = [name for name in PACKAGES if find_spec(name) is None]
    if missing:
        return NoReader(f"{' and '.join(missing)} not installed; install stucksolver-language again")
    from stucksolver_language.intent.network import NetworkReader

    return NetworkReader()


__all__ = ["interpreter"]
