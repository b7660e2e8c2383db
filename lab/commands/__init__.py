"""Commands for training and scoring networks: `python -m lab perception` and `python -m lab distill`."""

from stucksolver.commands.command_table import CliCommand

COMMANDS = {
    "perception": CliCommand("record drives, train perception on them, and score it", "lab.commands.perception"),
    "distill": CliCommand(
        "collect training data of the student, train it, score it and export it", "lab.commands.distill"
    ),
}
