"""Settings: values for the options of the commands, from a configuration file or the environment.

An option on the command line has priority. Otherwise the first of these with a value applies: the command's environment
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
"""Section that applies to every command with an option of that name."""
YES, NO = ("1", "true", "yes", "on"), ("0", "false", "no", "off")
IN_PLACE_OF = (("seed", "seeds"),)
"""Options that replace each other but may be given together."""
UNSET: tuple[object, ...] = ("", [])
"""Values in a file that keep the default."""
COMMAND_LINE_ONLY = ("help", "version", "config", "json", "unguarded", "heedless", "send-key")
"""Options that are not settings. An experiment without the guard must be requested explicitly each time. So must
sending a key to a server, because a file may name that server.
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
        """Name in a file: the option's name without the leading dashes."""
        return long_name(self.action)

    @property
    def switch(self) -> bool:
        """True if the option is a flag without a value."""
        return self.action.nargs == 0

    @property
    def several(self) -> bool:
        """True if the option takes a list."""
        return isinstance(self.action, argparse._AppendAction) or self.action.nargs in ("+", "*")

    def variable(self, section: str | None = None) -> str:
        """Return the environment variable of the setting, for its own section or for the given one."""
        return "_".join((PREFIX, section or self.section, self.key)).replace(".", "_").replace("-", "_").upper()

    def read(self, value: object, source: str) -> Any:
        """Return the option's value for a value from a file. Raises `UsageError` with the source."""
        if self.switch:
            if not isinstance(value, bool):
                raise UsageError(f"{source}: expected true or false, got {value!r}")
            return value
        if self.several:
            if not isinstance(value, list):
                raise UsageError(f"{source}: expected a list, got {value!r}")
            return [self._one(each, source) for each in value]
        return self._one(value, source)

    def read_text(self, text: str, source: str) -> Any:
        """Return the option's value for a variable's text; a list is split as in a shell. Raises `UsageError`."""
        if self.switch:
            if text.lower() not in (*YES, *NO):
                raise UsageError(f"{source}: expected 1 or 0, got '{text}'")
            return text.lower() in YES
        return self.read(shlex.split(text) if self.several else text, source)

    def _one(self, value: object, source: str) -> Any:
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise UsageError(f"{source}: expected {'a list' if self.several else 'one value'}, got {value!r}")
        convert = self.action.type or str
        try:
            result = convert(str(value)) if callable(convert) else value
        except argparse.ArgumentTypeError as error:
            raise UsageError(f"{source}: {error}") from error
        except (TypeError, ValueError) as error:
            raise UsageError(f"{source}: invalid value {value!r}") from error
        if self.action.choices is not None and result not in self.action.choices:
            raise UsageError(f"{source}: invalid value {value!r}; choose from {', '.join(self.action.choices)}")
        return result


@dataclass(frozen=True)
class SettingValue:
    """Value of a setting with its source. It replaces the option's default until parsing is done."""

    value: Any
    source: str
    default: Any = None
    """Default of the option."""

    def __str__(self) -> str:
        return f"{self.value}, from {self.source}"

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


def find_file(path: str | None, environment: Mapping[str, str] = os.environ) -> Path | None:
    """Return the configuration file: `path`, or that of the variable, of this folder or of the user.

    Raises:
        UsageError: The file does not exist.
    """
    named = path or environment.get(VARIABLE)
    if named == NO_FILE:
        return None
    if named:
        if not Path(named).is_file():
            raise UsageError(f"{named}: no such configuration file; `stucksolver config init` writes one")
        return Path(named)
    base = environment.get("XDG_CONFIG_HOME")
    users = (Path(base) if base else Path.home() / ".config") / "stucksolver" / "config.toml"
    return next((candidate for candidate in (Path(FILE), users) if candidate.is_file()), None)


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
    """Check that every section, key and value is valid for a command. Raises `UsageError`."""
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
        return None  # The simulator reads this variable itself.
    for section in (setting.section, ALL):
        inside: Any = content
        for part in section.split("."):
            inside = inside.get(part, {}) if isinstance(inside, dict) else {}
        value = inside.get(setting.key, "") if isinstance(inside, dict) else ""
        if value not in UNSET:
            return SettingValue(setting.read(value, f"{file}: [{section}] {setting.key}"), str(file))
    return None


def put_in(parser: argparse.ArgumentParser, values: Sequence[tuple[CliSetting, SettingValue]]) -> None:
    """Make the values the options' defaults; a required option with a value becomes optional.

    This precedes parsing, so that an option on the command line replaces the value.
    """
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
    """Replace each `SettingValue` by its content, and return the settings that were used.

    A flag overrides the settings that it excludes.
    """
    overridden = set[str]()
    for item in _all_parsers(parser):
        for rivals in _rivals(item):
            on_command_line = [
                hasattr(options, action.dest) and getattr(options, action.dest) is not action.default
                for action in rivals
            ]
            if any(on_command_line) and any(isinstance(action.default, SettingValue) for action in rivals):
                overridden.update(action.dest for action in rivals)
    used = []
    for name, value in list(vars(options).items()):
        if isinstance(value, SettingValue):
            setattr(options, name, value.default if name in overridden else value.value)
            used += [] if name in overridden or not value.source else [(name, value)]
    return used


def _rivals(parser: argparse.ArgumentParser) -> Iterator[list[argparse.Action]]:
    """Yield the groups of options of which only one applies."""
    for group in parser._mutually_exclusive_groups:
        yield list(group._group_actions)
    for names in IN_PLACE_OF:
        actions = [action for action in parser._actions if action.dest in names]
        if len(actions) > 1:
            yield actions


def _converted(action: argparse.Action) -> Any:
    """Return the default as argparse does: a text is parsed like an argument."""
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
