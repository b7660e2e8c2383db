"""`stucksolver completion`: scripts that make a shell complete commands, options and their choices.

They are generated from the parsers, so they always match this version, and need no other package.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

SHELLS = ("bash", "zsh", "fish")
INSTALL = """\
bash: stucksolver completion bash > ~/.local/share/bash-completion/completions/stucksolver
zsh:  stucksolver completion zsh > ~/.zfunc/_stucksolver   (a folder of $fpath)
fish: stucksolver completion fish > ~/.config/fish/completions/stucksolver.fish"""


@dataclass(frozen=True)
class Option:
    """One option. `takes`: it takes a value; `choices`: all its possible values; `files`: its value is a path."""

    names: tuple[str, ...]
    about: str
    takes: bool
    choices: tuple[str, ...]
    files: bool


@dataclass(frozen=True)
class Node:
    """A command or subcommand. `words` is the path to it; `below` has the words that may follow, with their help."""

    words: tuple[str, ...]
    below: tuple[tuple[str, str], ...]
    options: tuple[Option, ...]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = INSTALL
    parser.add_argument("shell", choices=SHELLS, help="the shell to write for")


def run(options: argparse.Namespace) -> int:
    """Print the script for the chosen shell. Returns 0."""
    from stucksolver.cli.main import full_parser  # imported here because `main` imports this module

    writers = {"bash": bash, "zsh": zsh, "fish": fish}
    print(writers[options.shell](list(nodes(full_parser()))), end="")
    return 0


def nodes(parser: argparse.ArgumentParser, words: tuple[str, ...] = ()) -> Iterator[Node]:
    """Yield the program, its commands and their subcommands, from the top down."""
    below: list[tuple[str, str]] = []
    parts: dict[str, argparse.ArgumentParser] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            parts.update(action.choices)
            below += [(one.dest, one.help or "") for one in action._choices_actions]
        elif not action.option_strings and action.choices:
            below += [(str(choice), "") for choice in action.choices]
    yield Node(words, tuple(below), tuple(_option(a) for a in parser._actions if a.option_strings))
    for name, part in parts.items():
        yield from nodes(part, (*words, name))


def _option(action: argparse.Action) -> Option:
    return Option(
        tuple(action.option_strings),
        (action.help or "").replace("%%", "%"),
        action.nargs != 0,
        tuple(map(str, action.choices or ())),
        action.type is Path,
    )


def _value_cases(tree: list[Node], write: Callable[[Option], str]) -> list[str]:
    """Return the branches of a `case` statement that complete option values, one for each option that takes a value."""
    return [
        f"    {_quoted(f'{_path(node)} {name}')}) {write(option)}; return ;;"
        for node in tree
        for option in node.options
        if option.takes
        for name in option.names
    ]


def bash(tree: list[Node]) -> str:
    """Return a completion script for bash 4 and later."""
    cases = [f"    {_quoted(_path(node))}) offered={_quoted(' '.join(_offered(node)))} ;;" for node in tree]
    values = _value_cases(tree, _bash_value)
    parts = "|".join(_quoted(_path(node)) for node in tree if node.words)
    return f"""\
# Completion of stucksolver for bash, written by `stucksolver completion bash`.
_stucksolver() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} path=- word longer offered=
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    longer="$path $word"; longer=${{longer#- }}
    case $longer in {parts}) path=$longer ;; esac
  done
  case "$path $before" in
{chr(10).join(values)}
  esac
  case $path in
{chr(10).join(cases)}
  esac
  COMPREPLY=($(compgen -W "$offered" -- "$current"))
  [[ ${{#COMPREPLY[@]}} -gt 0 || $current == -* ]] || COMPREPLY=($(compgen -f -- "$current"))
}}
complete -o filenames -F _stucksolver stucksolver
"""


def zsh(tree: list[Node]) -> str:
    """Return a completion script for zsh; it belongs in a folder of `fpath`."""
    cases = []
    for node in tree:
        words = " ".join(_quoted(f"{_colons(name)}:{_colons(about)}") for name, about in node.below)
        options = " ".join(
            _quoted(f"{name}:{_colons(option.about)}") for option in node.options for name in option.names
        )
        cases.append(f"    {_quoted(_path(node))}) words_=({words}); options_=({options}) ;;")
    values = _value_cases(tree, _zsh_value)
    parts = "|".join(_quoted(_path(node)) for node in tree if node.words)
    return f"""\
#compdef stucksolver
# Completion of stucksolver for zsh, written by `stucksolver completion zsh`.
_stucksolver() {{
  local path_=- word longer
  local -a words_ options_
  for word in ${{words[2,CURRENT-1]}}; do
    longer="$path_ $word"; longer=${{longer#- }}
    case $longer in {parts}) path_=$longer ;; esac
  done
  case "$path_ ${{words[CURRENT-1]}}" in
{chr(10).join(values)}
  esac
  case $path_ in
{chr(10).join(cases)}
  esac
  if [[ $PREFIX == -* ]]; then
    _describe option options_
  elif (( $#words_ )); then
    _describe command words_
  else
    _files
  fi
}}
if [[ $funcstack[1] == _stucksolver ]]; then _stucksolver "$@"; else compdef _stucksolver stucksolver; fi
"""


def fish(tree: list[Node]) -> str:
    """Return a completion script for fish 3 and later."""
    lines = ["# Completion of stucksolver for fish, written by `stucksolver completion fish`."]
    names = " ".join(name for name, _ in tree[0].below)
    for node in tree:
        seen = [f"__fish_seen_subcommand_from {word}" for word in node.words]
        if not node.words:
            seen = [f"not __fish_seen_subcommand_from {names}"]
        inner = " ".join(name for name, _ in node.below)
        here = "; and ".join([*seen, *([f"not __fish_seen_subcommand_from {inner}"] if inner and node.words else [])])
        start = f"complete -c stucksolver -n {_quoted(here)}"
        lines += [f"{start} -f -a {_quoted(name)} -d {_quoted(about)}" for name, about in node.below]
        for option in node.options:
            given = " ".join(f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}" for name in option.names)
            value = ""
            if option.takes:
                value = f" -x -a {_quoted(' '.join(option.choices))}" if option.choices else " -r"
            lines.append(f"{start} {given}{value} -d {_quoted(option.about)}")
    return "\n".join(lines) + "\n"


def _path(node: Node) -> str:
    return " ".join(node.words) or "-"


def _offered(node: Node) -> list[str]:
    return [*(name for name, _ in node.below), *(name for option in node.options for name in option.names)]


def _bash_value(option: Option) -> str:
    if option.choices:
        return f'COMPREPLY=($(compgen -W {_quoted(" ".join(option.choices))} -- "$current"))'
    return 'COMPREPLY=($(compgen -f -- "$current"))' if option.files else "COMPREPLY=()"


def _zsh_value(option: Option) -> str:
    if option.choices:
        return f"compadd -- {' '.join(map(_quoted, option.choices))}"
    return "_files" if option.files else "_message value"


def _quoted(text: str) -> str:
    """Quote with single quotes in a way that bash, zsh and fish read alike."""
    return "'" + text.replace("'", "’") + "'"


def _colons(text: str) -> str:
    return text.replace(":", "\\:")
