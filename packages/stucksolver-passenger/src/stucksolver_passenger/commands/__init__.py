"""Commands on the passenger's page and the memory."""

from stucksolver.commands.command_table import Command

COMMANDS = {
    "memory": Command(
        "list, show, export or delete what is remembered of earlier drives", "stucksolver_passenger.commands.memory"
    ),
    "voice": Command(
        "install a speech recognizer for the passenger's page, which runs in the browser",
        "stucksolver_passenger.commands.voice",
    ),
}
