"""Lists the commands that use a running CARLA server."""

from stucksolver.commands.command_table import CliCommand

COMMANDS = {
    "watch": CliCommand(
        "observe a vehicle in a running simulator: detect, reason, check and record, but never act",
        "stucksolver_carla.commands.watch",
        drives=True,
    ),
}
