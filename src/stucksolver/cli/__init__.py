"""The commands."""

from stucksolver.cli.main import main

__all__ = ["main"]
