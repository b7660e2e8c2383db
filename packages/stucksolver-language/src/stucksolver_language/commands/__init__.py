"""Commands for language models and the interpreter of utterances."""

from stucksolver.commands.command_table import CliCommand

COMMANDS = {
    "prompt": CliCommand(
        "print the prompt that a language model gets for a scene", "stucksolver_language.commands.prompt"
    ),
    "words": CliCommand(
        "interpret passengers' utterances: JSON lines of situation and text in, interpretations out",
        "stucksolver_language.commands.interpret",
    ),
}
