"""Contains this distribution's parts of the `stucksolver` program."""
