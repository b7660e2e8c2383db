"""Reads a passenger's words."""

from stucksolver.words.reader import MISSING, NoReader, ScriptedReader, WordsReader, find_reader
from stucksolver.words.situation import situation_of

__all__ = ["MISSING", "NoReader", "ScriptedReader", "WordsReader", "find_reader", "situation_of"]
