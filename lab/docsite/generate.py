"""Reference pages that are generated from the program: its commands, settings, schemas and HTTP API."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from typing import Any

PROSE_TYPES = {"null": "nothing", "string": "text", "integer": "whole number", "boolean": "yes or no"}


def commands_page() -> str:
    """Return a page with every command and its options, from the parsers."""
    from stucksolver.commands.main import EXIT_CODES, full_parser

    lines = [
        "# Commands",
        "",
        "Generated from the parsers of this version; `stucksolver COMMAND --help` prints the same.",
        "",
        f"An error is one line on standard error. {EXIT_CODES[0].upper()}{EXIT_CODES[1:]}. They are the same for every "
        "command.",
        "",
        "With `--json`, standard output contains only JSON of the shape that the option's description shows, and the "
        "exit code stays the same; notes and progress go to standard error. `memory show` and `words` always print "
        "JSON, `memory export` JSON lines. `evaluate` and `score` also write `summary.json`.",
        "",
    ]
    from lab.commands import COMMANDS

    ours, lab = full_parser(), full_parser("python -m lab", COMMANDS)
    for name, part, about in (*_parts(ours), *_parts(lab, "python -m lab")):
        lines += [f"## {name}", "", f"{about[0].upper()}{about[1:]}.".replace("..", ".").replace("?.", "?"), ""]
        lines += [*_options(part), ""]
    return "\n".join(lines)


def _parts(parser: argparse.ArgumentParser, before: str = "stucksolver") -> Iterator[tuple[str, Any, str]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            helps = {item.dest: item.help or "" for item in action._choices_actions}
            for name, part in action.choices.items():
                yield f"{before} {name}", part, part.description or helps[name]
                yield from _parts(part, f"{before} {name}")


def _options(parser: argparse.ArgumentParser) -> list[str]:
    rows = []
    for action in parser._actions:
        if isinstance(action, argparse._HelpAction | argparse._SubParsersAction):
            continue
        name = ", ".join(f"`{string}`" for string in action.option_strings) or f"`{action.dest}`"
        value = "" if action.nargs == 0 or not action.option_strings else f" `{action.metavar or _kind(action)}`"
        default = "" if action.default in (None, False, "", (), []) else f"`{action.default}`"
        help_text = _cell((action.help or "").replace("%%", "%"))
        rows.append(f"| {name}{value} | {help_text}{' **(required)**' if action.required else ''} | {default} |")
    return ["| option | meaning | default |", "|---|---|---|", *rows] if rows else ["It has subcommands; see below."]


def _kind(action: argparse.Action) -> str:
    return ",".join(map(str, action.choices)) if action.choices else action.dest.upper()


def settings_page() -> str:
    """Return a page with the complete configuration file."""
    from stucksolver.commands.config import template

    return f"{SETTINGS}\n```toml\n{template()}```\n"


SETTINGS = """\
# Configuration

Every option of every command can be set in one file. `stucksolver config init` writes the file below.
`stucksolver config show` prints the settings in effect and where they come from.

The first of these that has a value applies:

1. the option on the command line,
2. the command's environment variable, such as `STUCKSOLVER_DEMO_SEED` for `[demo] seed`,
3. the environment variable for all commands, such as `STUCKSOLVER_ALL_SEED`,
4. the command's section in the file, `[demo]`,
5. the section `[all]` in the file,
6. the default.

Only one file is read: the one given as `stucksolver --config FILE COMMAND`, else the one that `STUCKSOLVER_CONFIG`
names, else `stucksolver.toml` in the current folder, else `stucksolver/config.toml` in `$XDG_CONFIG_HOME` or
`~/.config`. `--config none` reads no file. An unknown key is an error, and the message suggests the closest known one.
Settings that come from the file or the environment are listed on standard error.

`--unguarded` and `--heedless` cannot be set here: an experiment without the guard must be requested each time. API
keys of language models are read from the environment only ([model.md](../model.md)). `STUCKSOLVER_MAPS` and
`CARLA_AGENTS` name folders with towns and with CARLA's `agents`. `carlette` has its own options, and reads no file.
"""


def schemas_page() -> str:
    """Return a page with the types that cross the boundary between stack and solver."""
    from stucksolver.plan.json_schemas import VERSION, schemas

    lines = [
        "# Schemas",
        "",
        f"The types that cross the boundary between a stack and the solver, in JSON form, version {VERSION}. "
        "Units are SI units and radians. A `Scene` is in the ego frame of ISO 8855 (x forward, y left), everything "
        "else in a local frame that the stack chooses. As JSON schemas: "
        + ", ".join(f"[{name}.json](schemas/{name}.json)" for name in schemas())
        + ".",
        "",
    ]
    for name, schema in schemas().items():
        lines += [f"## {name}", ""]
        if "properties" in schema:
            lines += [*_fields(schema), ""]
        for kind, definition in schema.get("$defs", {}).items():
            heading = [f"### {name}: {kind}", "", *_about(definition)]
            if "properties" in definition:
                lines += [*heading, *_fields(definition), ""]
            elif "enum" in definition:
                lines += [*heading, f"One of {', '.join(f'`{item}`' for item in definition['enum'])}.", ""]
    return "\n".join(lines)


def schema_files() -> dict[str, str]:
    """Return the JSON schemas by file name."""
    from stucksolver.plan.json_schemas import schemas

    return {f"{name}.json": json.dumps(schema, indent=1) + "\n" for name, schema in schemas().items()}


def _about(definition: dict[str, Any]) -> list[str]:
    text = str(definition.get("description", "")).split("\n\n")[0].replace("\n", " ")
    return [text, ""] if text else []


def _fields(schema: dict[str, Any]) -> list[str]:
    required = schema.get("required", ())
    rows = []
    for name, field in schema["properties"].items():
        text = f"`{name}`" if name in required else f"`{name}` (optional)"
        rows.append(f"| {text} | {_type(field)} | {_cell(field.get('description', ''))} |")
    return ["| field | type | meaning |", "|---|---|---|", *rows]


def _type(field: dict[str, Any]) -> str:
    if "$ref" in field:
        return f"`{field['$ref'].rpartition('/')[2]}`"
    if "const" in field:
        return f"`{field['const']}`"
    if "enum" in field:
        return ", ".join(f"`{item}`" for item in field["enum"])
    for several in ("anyOf", "oneOf", "allOf"):
        if several in field:
            return " or ".join(dict.fromkeys(_type(item) for item in field[several]))
    if field.get("type") == "array":
        inside = field.get("items") or {}
        return f"list of {_type(inside) if inside else 'values'}"
    kind = str(field.get("type", "any"))
    bounds = [f"{sign} {field[key]}" for key, sign in BOUNDS.items() if key in field]
    return PROSE_TYPES.get(kind, kind) + (f", {', '.join(bounds)}" if bounds else "")


BOUNDS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}


def http_page() -> str:
    """Return a page on the passenger's HTTP API, from its OpenAPI document."""
    schema = openapi()
    lines = ["# HTTP API", "", schema["info"]["description"], ""]
    lines += [
        "`stucksolver ride` serves it together with the page ([passenger.md](../passenger.md)). "
        "The complete description: [openapi.json](openapi.json).",
        "",
    ]
    for path, methods in schema["paths"].items():
        for method, call in methods.items():
            lines += [f"## {method.upper()} {path}", "", call.get("description") or call.get("summary", ""), ""]
            rows = [
                f"| `{item['name']}` | {item['in']} | {_type(item.get('schema', {}))} |"
                for item in call.get("parameters", ())
            ]
            body = call.get("requestBody", {}).get("content", {}).get("application/json", {}).get("schema")
            rows += [f"| body | JSON | {_type(body)} |"] if body else []
            lines += ["| parameter | where | type |", "|---|---|---|", *rows, ""] if rows else []
            answers = [f"{code} {item['description']}" for code, item in call["responses"].items()]
            lines += [f"Answers: {', '.join(answers)}.", ""]
    for name, definition in schema["components"]["schemas"].items():
        if "properties" in definition:
            lines += [f"## {name}", "", *_about(definition), *_fields(definition), ""]
    return "\n".join(lines)


def openapi() -> dict[str, Any]:
    """Return the document that the server provides at `/openapi.json`."""
    from stucksolver_passenger.access_tokens import Tokens
    from stucksolver_passenger.server.app import make_app
    from stucksolver_passenger.server.fleet_state import Board

    return make_app(Board(), Tokens()).openapi()


def _cell(text: str) -> str:
    return str(text).replace("\\|", "|").replace("|", "\\|").replace("[", "\\[").replace("\n", " ")
