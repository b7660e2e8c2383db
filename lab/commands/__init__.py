"""Commands for training and scoring networks: `python -m lab perception`."""

from stucksolver.commands.command_table import CliCommand

COMMANDS = {
    "perception": CliCommand("record drives, train perception on them, and score it", "lab.commands.perception"),
}
