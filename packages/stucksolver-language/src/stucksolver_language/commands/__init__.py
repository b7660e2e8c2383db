"""Commands on language models and the interpreter of words."""

from stucksolver.commands.command_table import CliCommand

COMMANDS = {
    "prompt": CliCommand(
        "show what would be sent to a language model for a scene", "stucksolver_language.commands.prompt"
    ),
    "words": CliCommand(
        "interpret passengers' words: JSON lines of situation and text in, readings out",
        "stucksolver_language.commands.interpret",
    ),
}
