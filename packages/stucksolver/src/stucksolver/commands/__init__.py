"""Commands of the `stucksolver` program."""

from stucksolver.commands.main import main

__all__ = ["main"]
