"""Commands for the passenger's page and the memory."""

from stucksolver.commands.command_table import CliCommand

COMMANDS = {
    "memory": CliCommand(
        "list, show, export or delete what the memory stores of earlier drives", "stucksolver_passenger.commands.memory"
    ),
    "voice": CliCommand(
        "install a speech recognizer for the passenger's page, which runs in the browser",
        "stucksolver_passenger.commands.voice",
    ),
}
