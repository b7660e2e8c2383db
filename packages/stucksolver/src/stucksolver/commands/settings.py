"""Settings: values for the options of the commands, from a configuration file or the environment.

An option on the command line wins. Otherwise the first of these that has a value applies: the command's environment
variable, the variable for all commands, the command's section in the file, the file's section `[all]`, the default.
"""

from __future__ import annotations

import argparse
import difflib
import os
import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from stucksolver.commands.errors import UsageError
from stucksolver.privacy.url_redaction import without_logins

FILE = "stucksolver.toml"
VARIABLE = "STUCKSOLVER_CONFIG"
PREFIX = "STUCKSOLVER"
NO_FILE = "none"
ALL = "all"
"""The section that applies to every command with an option of that name."""
YES, NO = ("1", "true", "yes", "on"), ("0", "false", "no", "off")
IN_PLACE_OF = (("seed", "seeds"),)
"""Options that replace each other but may be given together."""
UNSET: tuple[object, ...] = ("", [])
"""Values in a file that keep the default."""
COMMAND_LINE_ONLY = ("help", "version", "config", "json", "unguarded", "heedless", "send-key")
"""Options that are not settings. An experiment without the guard must be requested explicitly each time, and so must
sending a key to a server that a file may name.
"""


@dataclass(frozen=True)
class CliSetting:
    """One option of one command.

    `section` is the command, with its subcommand after a dot: `memory.forget`.
    """

    section: str
    action: argparse.Action

    @property
    def key(self) -> str:
        """Its name in a file: the option's name without the leading dashes."""
        return long_name(self.action)

    @property
    def switch(self) -> bool:
        """True if it is a flag without a value."""
        return self.action.nargs == 0

    @property
    def several(self) -> bool:
        """True if it takes a list."""
        return isinstance(self.action, argparse._AppendAction) or self.action.nargs in ("+", "*")

    def variable(self, section: str | None = None) -> str:
        """Return its environment variable, for its own section or for the one given."""
        return "_".join((PREFIX, section or self.section, self.key)).replace(".", "_").replace("-", "_").upper()

    def read(self, value: object, source: str) -> Any:
        """Convert a value from a file to the option's value. Raises `UsageError` that names the source."""
        if self.switch:
            if not isinstance(value, bool):
                raise UsageError(f"{source}: {value!r} is not possible; give true or false")
            return value
        if self.several:
            if not isinstance(value, list):
                raise UsageError(f"{source}: {value!r} is not possible; give a list")
            return [self._one(each, source) for each in value]
        return self._one(value, source)

    def read_text(self, text: str, source: str) -> Any:
        """Convert a variable's text to the option's value; a list is split as in a shell. Raises `UsageError`."""
        if self.switch:
            if text.lower() not in (*YES, *NO):
                raise UsageError(f"{source}: '{text}' is not possible; give 1 or 0")
            return text.lower() in YES
        return self.read(shlex.split(text) if self.several else text, source)

    def _one(self, value: object, source: str) -> Any:
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise UsageError(f"{source}: {value!r} is not possible; give {'a list' if self.several else 'one value'}")
        convert = self.action.type or str
        try:
            found = convert(str(value)) if callable(convert) else value
        except argparse.ArgumentTypeError as error:
            raise UsageError(f"{source}: {error}") from error
        except (TypeError, ValueError) as error:
            raise UsageError(f"{source}: {value!r} is not possible") from error
        if self.action.choices is not None and found not in self.action.choices:
            raise UsageError(f"{source}: {value!r} is not possible; choose from {', '.join(self.action.choices)}")
        return found


@dataclass(frozen=True)
class SettingValue:
    """A setting's value and its source. It takes the place of the option's default until parsing is done."""

    value: Any
    source: str
    default: Any = None
    """The option's own default."""

    def __str__(self) -> str:
        return f"{self.value}, by {self.source}"

    def __copy__(self) -> list[Any]:
        """Return the empty list to which argparse appends, so that flags replace the setting's values."""
        return []


def long_name(action: argparse.Action) -> str:
    """Return `jobs` for `--jobs`, or an empty text for an argument without a long option."""
    return next((name[2:] for name in action.option_strings if name.startswith("--")), "")


def settings_of(section: str, parser: argparse.ArgumentParser) -> Iterator[CliSetting]:
    """Yield all settings of a command and its subcommands."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, part in action.choices.items():
                yield from settings_of(f"{section}.{name}".lstrip("."), part)
        elif long_name(action) and long_name(action) not in COMMAND_LINE_ONLY:
            yield CliSetting(section, action)


def find_file(told: str | None, environment: Mapping[str, str] = os.environ) -> Path | None:
    """Return the file to read: `told`, or the variable's, this folder's or the user's file. Raises `UsageError`."""
    named = told or environment.get(VARIABLE)
    if named == NO_FILE:
        return None
    if named:
        if not Path(named).is_file():
            raise UsageError(f"{named}: no such configuration file; `stucksolver config init` writes one")
        return Path(named)
    base = environment.get("XDG_CONFIG_HOME")
    users = (Path(base) if base else Path.home() / ".config") / "stucksolver" / "config.toml"
    return next((path for path in (Path(FILE), users) if path.is_file()), None)


def read_file(file: Path) -> dict[str, Any]:
    """Return the sections of a file. Raises `UsageError` if it cannot be read or is not TOML."""
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        return dict(without_logins(tomllib.loads(file.read_text(encoding="utf-8"))))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UsageError(f"{file} cannot be read: {error}; `stucksolver config init` writes a valid one") from error


def check_file(file: Path, content: Mapping[str, Any], known: Sequence[CliSetting]) -> None:
    """Check that every section, key and value is valid for some command. Raises `UsageError`."""
    keys: dict[str, dict[str, CliSetting]] = {ALL: {}}
    for item in known:
        keys.setdefault(item.section, {})[item.key] = item
        keys[ALL].setdefault(item.key, item)
        for k in range(item.section.count(".")):
            keys.setdefault(item.section.rsplit(".", k + 1)[0], {})
    for section, key, value in _entries(content):
        if not section:
            raise UsageError(f"{file}: '{key}' is outside any section; put it under [{ALL}] or a command's section")
        if section not in keys:
            raise UsageError(f"{file}: there is no section [{section}]{_nearest(section, keys)}")
        if key not in keys[section]:
            raise UsageError(f"{file}: [{section}] has no setting '{key}'{_nearest(key, keys[section])}")
        if section != ALL and value not in UNSET:
            keys[section][key].read(value, f"{file}: [{section}] {key}")


def lookup(
    setting: CliSetting, content: Mapping[str, Any], file: Path | None, environment: Mapping[str, str] = os.environ
) -> SettingValue | None:
    """Return a setting's value from the environment or the file, or None. Raises `UsageError`."""
    for section in (setting.section, ALL):
        name = setting.variable(section)
        if environment.get(name):
            return SettingValue(setting.read_text(without_logins(environment[name]), name), name)
    if setting.key == "maps" and environment.get("STUCKSOLVER_MAPS"):
        return None  # the simulator reads this variable itself
    for section in (setting.section, ALL):
        inside: Any = content
        for part in section.split("."):
            inside = inside.get(part, {}) if isinstance(inside, dict) else {}
        value = inside.get(setting.key, "") if isinstance(inside, dict) else ""
        if value not in UNSET:
            return SettingValue(setting.read(value, f"{file}: [{section}] {setting.key}"), str(file))
    return None


def put_in(parser: argparse.ArgumentParser, values: Sequence[tuple[CliSetting, SettingValue]]) -> None:
    """Make the values the options' defaults; a required option that has one becomes optional."""
    for setting, value in values:
        setting.action.default = replace(value, default=_converted(setting.action))
        setting.action.required = False
    for item in _all_parsers(parser):
        for group in item._mutually_exclusive_groups:
            if any(isinstance(action.default, SettingValue) for action in group._group_actions):
                group.required = False
        for rivals in _rivals(item):
            if any(isinstance(action.default, SettingValue) for action in rivals):
                for action in rivals:
                    if not isinstance(action.default, SettingValue):
                        # This distinguishes a flag that repeats the default from a missing flag.
                        action.default = SettingValue(_converted(action), "", _converted(action))


def taken_out(parser: argparse.ArgumentParser, options: argparse.Namespace) -> list[tuple[str, SettingValue]]:
    """Replace each `SettingValue` by its content; returns those that were used.

    A flag overrides the settings it excludes.
    """
    beaten = set[str]()
    for item in _all_parsers(parser):
        for rivals in _rivals(item):
            told = [
                hasattr(options, action.dest) and getattr(options, action.dest) is not action.default
                for action in rivals
            ]
            if any(told) and any(isinstance(action.default, SettingValue) for action in rivals):
                beaten.update(action.dest for action in rivals)
    used = []
    for name, value in list(vars(options).items()):
        if isinstance(value, SettingValue):
            setattr(options, name, value.default if name in beaten else value.value)
            used += [] if name in beaten or not value.source else [(name, value)]
    return used


def _rivals(parser: argparse.ArgumentParser) -> Iterator[list[argparse.Action]]:
    """Yield the groups of options of which only one applies."""
    for group in parser._mutually_exclusive_groups:
        yield list(group._group_actions)
    for names in IN_PLACE_OF:
        found = [action for action in parser._actions if action.dest in names]
        if len(found) > 1:
            yield found


def _converted(action: argparse.Action) -> Any:
    """Return the default as argparse would: a text is parsed as if it had been given."""
    if isinstance(action.default, str) and callable(action.type):
        return action.type(action.default)
    return action.default


def _entries(content: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str, Any]]:
    for name, value in content.items():
        section = f"{above}.{name}" if above else name
        if isinstance(value, dict):
            yield from _entries(value, section)
        else:
            yield above, name, value


def _nearest(name: str, known: Mapping[str, object]) -> str:
    near = difflib.get_close_matches(name, known, 1, 0.5)
    return f"; did you mean '{near[0]}'?" if near else f"; choose from {', '.join(sorted(known))}"


def _all_parsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for part in action.choices.values():
                yield from _all_parsers(part)
