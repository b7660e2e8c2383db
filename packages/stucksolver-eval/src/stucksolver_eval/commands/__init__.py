"""Commands of evaluations, the demonstration and the ride."""

from stucksolver.commands.command_table import CliCommand

COMMANDS = {
    "demo": CliCommand(
        "drive past a parked car and two cyclists, without and with StuckSolver, and write a report",
        "stucksolver_eval.commands.demo",
        drives=True,
    ),
    "ride": CliCommand(
        "ride along a street with a page for conversation with the car", "stucksolver_eval.commands.ride", drives=True
    ),
    "evaluate": CliCommand(
        "drive a suite of routes with scenarios, and score it", "stucksolver_eval.commands.evaluate", drives=True
    ),
    "score": CliCommand("compute all scores of evaluations from their files", "stucksolver_eval.commands.score"),
    "compare": CliCommand(
        "test whether one evaluation is better than another",
        "stucksolver_eval.commands.score",
        "add_compare_options",
        "run_compare",
        more="Tests whether evaluation B is better than A. Prints driving score, success rate and route completion of "
        "both, the difference B - A over the routes and seeds that both drove, with its 95 % interval and p-value, "
        "what their recoveries did, and the routes that B won and lost. Each of several Bs is compared with A.",
    ),
    "cases": CliCommand(
        "run the cases of Bao and Li 2025 with a reasoner, and draw them",
        "stucksolver_eval.commands.cases",
        drives=True,
    ),
}
