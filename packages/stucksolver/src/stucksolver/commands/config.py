"""`stucksolver config`: shows the settings in effect and their sources, and writes a file to start from."""

from __future__ import annotations

import argparse
import json
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from stucksolver.commands.arguments import Parser, add_json, print_json
from stucksolver.commands.errors import UsageError
from stucksolver.commands.settings import (
    FILE,
    VARIABLE,
    CliSetting,
    check_file,
    find_file,
    lookup,
    read_file,
    settings_of,
)

HEAD = f"""\
# Settings of StuckSolver. Remove the # before a line to use it.
#
# An option on the command line has priority. Then come, in this order: the environment
# (STUCKSOLVER_DEMO_SEED for [demo] seed, STUCKSOLVER_ALL_SEED for [all] seed), the section of the command, [all].
# The file is the one that `--config FILE` or {VARIABLE} names; else {FILE} in the current folder; else
# stucksolver/config.toml in $XDG_CONFIG_HOME or ~/.config. `stucksolver config show` prints the values in effect.
# Keys of language models do not belong here: they are read from the environment only.

# For every command that has the setting.
[all]
# seed = 1
"""
LINE = 110
"""Longest line of an explanation in the file (characters)."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parts = parser.add_subparsers(required=True, metavar="SUBCOMMAND", help="action", parser_class=Parser)
    show = parts.add_parser("show", help="print each setting that differs from its default, and its source")
    show.add_argument("command", nargs="?", help="only the settings of this command, such as demo")
    show.add_argument("--defaults", action="store_true", help="print the settings with their default value as well")
    add_json(show, '{"file": path or null, "settings": [{"section", "key", "value", "source", "variable"}]}')
    show.set_defaults(part=_show)
    init = parts.add_parser("init", help="write a file that explains every setting")
    init.add_argument("file", nargs="?", type=Path, default=Path(FILE), help="file to write")
    init.set_defaults(part=_init)


def run(options: argparse.Namespace) -> int:
    """Run the requested subcommand and return its exit code. Raises `UsageError`."""
    return int(options.part(options))


def all_settings() -> list[CliSetting]:
    """Return the settings of all commands."""
    from stucksolver.commands.main import full_parser  # Imported here because `main` imports this module.

    return list(settings_of("", full_parser()))


def _show(options: argparse.Namespace) -> int:
    known = all_settings()
    sections = {item.section.split(".")[0] for item in known}
    if options.command is not None and options.command not in sections:
        raise UsageError(f"'{options.command}' has no settings; choose from {', '.join(sorted(sections))}")
    file = find_file(options.config)
    content = read_file(file) if file else {}
    if file:
        check_file(file, content, known)
    rows = []
    for item in known:
        if options.command not in (None, item.section.split(".")[0]):
            continue
        value = lookup(item, content, file)
        if value or options.defaults:
            rows.append(
                {
                    "section": item.section,
                    "key": item.key,
                    "value": value.value if value else item.action.default,
                    "source": value.source if value else "default",
                    "variable": item.variable(),
                }
            )
    if options.json:
        print_json({"file": str(file) if file else None, "settings": rows})
        return 0
    print(f"file: {file or 'none; `stucksolver config init` writes one'}")
    for row in rows:
        print(f"{row['section']}.{row['key']} = {_toml(row['value'])}  ({row['source']})")
    if not rows:
        print("every setting has its default; --defaults lists them")
    return 0


def _init(options: argparse.Namespace) -> int:
    try:
        with options.file.open("x", encoding="utf-8") as file:
            file.write(template())
    except FileExistsError:
        raise UsageError(f"{options.file} already exists; name another file, or remove it") from None
    except OSError as error:
        raise UsageError(f"{options.file}: cannot be written: {error}") from error
    print(f"{options.file}: every setting with its default, commented out")
    return 0


def template() -> str:
    """Return a file that explains every setting, all commented out. It is valid TOML with and without the `# `."""
    lines = [HEAD]
    section = ""
    for setting in all_settings():
        if setting.section != section:
            section = setting.section
            lines.append(f"\n[{section}]")
        lines += _explained(setting)
    return "\n".join(lines) + "\n"


def _explained(setting: CliSetting) -> Iterator[str]:
    explanation = (setting.action.help or "").replace("%%", "%")
    if setting.action.choices is not None:
        explanation += f" ({', '.join(map(str, setting.action.choices))})"
    yield from textwrap.wrap(explanation, LINE, initial_indent="## ", subsequent_indent="## ")
    yield f"# {setting.key} = {_example(setting)}"


def _example(setting: CliSetting) -> str:
    """Return the default as TOML, or an empty value of the expected type without a default."""
    if setting.switch:
        return "false"
    default = setting.action.default
    if setting.several:
        return _toml(list(default) if default else [])
    return _toml("" if default is None else default)


def _toml(value: Any) -> str:
    """Return a value as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_toml(each) for each in value)}]"
    return json.dumps("" if value is None else str(value), ensure_ascii=False)
