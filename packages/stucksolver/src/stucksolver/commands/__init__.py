"""The commands."""

from stucksolver.commands.main import main

__all__ = ["main"]
