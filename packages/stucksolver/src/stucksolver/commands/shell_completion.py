"""`stucksolver completion`: prints a script that makes a shell complete commands, options and their choices.

shtab generates it from the parsers, so it always matches this version.
"""

from __future__ import annotations

import argparse

from stucksolver.commands.errors import UsageError

SHELLS = ("bash", "zsh", "fish", "tcsh")
INSTALL = """\
bash: stucksolver completion bash > ~/.local/share/bash-completion/completions/stucksolver
zsh:  stucksolver completion zsh > ~/.zfunc/_stucksolver   (a folder of $fpath)
fish: stucksolver completion fish > ~/.config/fish/completions/stucksolver.fish"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = INSTALL
    parser.add_argument("shell", choices=SHELLS, help="shell of the script")


def run(options: argparse.Namespace) -> int:
    """Print the script for the chosen shell. Returns 0. Raises `UsageError` if shtab is not installed."""
    from stucksolver.commands.main import full_parser  # Imported here because `main` imports this module.

    try:
        from shtab import complete  # type: ignore[import-untyped,unused-ignore]
    except ImportError:
        raise UsageError("shtab is not installed; add the extra [completion] (README, Install)") from None
    print(complete(full_parser(), options.shell), end="")
    return 0
