"""Pages that are made from the program itself: its commands, settings, schemas and HTTP API."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from typing import Any

PROSE_TYPES = {"null": "nothing", "string": "text", "integer": "whole number", "boolean": "yes or no"}


def commands_page() -> str:
    """Every command with its options, as the parsers have them."""
    from stucksolver.cli.main import EXIT_CODES, full_parser

    lines = [
        "# Commands",
        "",
        "Made from the parsers of this version; `stucksolver COMMAND --help` prints the same.",
        "",
    ]
    lines += [
        f"Whatever is wrong with a call is one line on standard error. {EXIT_CODES[0].upper()}{EXIT_CODES[1:]}.",
        "",
    ]
    parser = full_parser()
    for name, part, about in _parts(parser):
        lines += [f"## {name}", "", f"{about[0].upper()}{about[1:]}.".replace("..", ".").replace("?.", "?"), ""]
        lines += [*_options(part), ""]
    return "\n".join(lines)


def _parts(parser: argparse.ArgumentParser, before: str = "stucksolver") -> Iterator[tuple[str, Any, str]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            told = {one.dest: one.help or "" for one in action._choices_actions}
            for name, part in action.choices.items():
                yield f"{before} {name}", part, part.description or told[name]
                yield from _parts(part, f"{before} {name}")


def _options(parser: argparse.ArgumentParser) -> list[str]:
    rows = []
    for action in parser._actions:
        if isinstance(action, argparse._HelpAction | argparse._SubParsersAction):
            continue
        name = ", ".join(f"`{one}`" for one in action.option_strings) or f"`{action.dest}`"
        value = "" if action.nargs == 0 or not action.option_strings else f" `{action.metavar or _kind(action)}`"
        default = "" if action.default in (None, False, "", (), []) else f"`{action.default}`"
        told = _cell((action.help or "").replace("%%", "%"))
        rows.append(f"| {name}{value} | {told}{' **(required)**' if action.required else ''} | {default} |")
    return ["| option | what it says | default |", "|---|---|---|", *rows] if rows else ["It has parts; see below."]


def _kind(action: argparse.Action) -> str:
    return ",".join(map(str, action.choices)) if action.choices else action.dest.upper()


def settings_page() -> str:
    """The configuration file, whole."""
    from stucksolver.cli.config import template

    return f"{SETTINGS}\n```toml\n{template()}```\n"


SETTINGS = """\
# Configuration

Every option of every command can stand in one file. `stucksolver config init` writes the file below;
`stucksolver config show` prints what counts now, and where it comes from; `--json` prints it for a script.

What counts, the first that has a value:

1. the option on the command line,
2. the variable of the command, such as `STUCKSOLVER_DEMO_SEED` for `[demo] seed`,
3. the variable of all commands, such as `STUCKSOLVER_ALL_SEED`,
4. the file's section of the command, `[demo]`,
5. the file's section `[all]`,
6. the default.

One file is read: that of `stucksolver --config FILE COMMAND`, else that of `STUCKSOLVER_CONFIG`, else
`stucksolver.toml` in the current folder, else `stucksolver/config.toml` in `$XDG_CONFIG_HOME` or `~/.config`.
`--config none` reads none. A key that no command has is an error that names the nearest one. What was taken from
file or environment is said on standard error.

`--unguarded` and `--heedless` cannot be set here: an experiment without the guard is asked for each time. Keys of
language models are read from the environment only ([model.md](../model.md)). `STUCKSOLVER_MAPS` and `CARLA_AGENTS`
name folders with towns and with CARLA's `agents`. `carlette` has options of its own, and no file.
"""


def schemas_page() -> str:
    """What crosses the boundary between stack and solver, type by type."""
    from stucksolver.decision.schema import VERSION, schemas

    lines = [
        "# Schemas",
        "",
        f"What crosses the boundary between a stack and the solver, in its JSON form of version {VERSION}. "
        "SI units and radians; a `Scene` is in the ego frame of ISO 8855 (x ahead, y left), everything else in a local "
        "frame of the stack's choice. The files: "
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
                lines += [*heading, f"One of {', '.join(f'`{one}`' for one in definition['enum'])}.", ""]
    return "\n".join(lines)


def schema_files() -> dict[str, str]:
    """The schemas as documents, by the name of the file."""
    from stucksolver.decision.schema import schemas

    return {f"{name}.json": json.dumps(schema, indent=1) + "\n" for name, schema in schemas().items()}


def _about(definition: dict[str, Any]) -> list[str]:
    told = str(definition.get("description", "")).split("\n\n")[0].replace("\n", " ")
    return [told, ""] if told else []


def _fields(schema: dict[str, Any]) -> list[str]:
    required = schema.get("required", ())
    rows = []
    for name, field in schema["properties"].items():
        told = f"`{name}`" if name in required else f"`{name}` (optional)"
        rows.append(f"| {told} | {_type(field)} | {_cell(field.get('description', ''))} |")
    return ["| field | type | meaning |", "|---|---|---|", *rows]


def _type(field: dict[str, Any]) -> str:
    if "$ref" in field:
        return f"`{field['$ref'].rpartition('/')[2]}`"
    if "const" in field:
        return f"`{field['const']}`"
    if "enum" in field:
        return ", ".join(f"`{one}`" for one in field["enum"])
    for several in ("anyOf", "oneOf", "allOf"):
        if several in field:
            return " or ".join(dict.fromkeys(_type(one) for one in field[several]))
    if field.get("type") == "array":
        inside = field.get("items") or {}
        return f"list of {_type(inside) if inside else 'values'}"
    kind = str(field.get("type", "any"))
    bounds = [f"{sign} {field[key]}" for key, sign in BOUNDS.items() if key in field]
    return PROSE_TYPES.get(kind, kind) + (f", {', '.join(bounds)}" if bounds else "")


BOUNDS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}


def http_page() -> str:
    """The passenger's HTTP API, from its OpenAPI document."""
    schema = openapi()
    lines = ["# HTTP API", "", schema["info"]["description"], ""]
    lines += [
        "`stucksolver ride` serves it beside the page ([passenger.md](../passenger.md)). "
        "All of it: [openapi.json](openapi.json).",
        "",
    ]
    for path, methods in schema["paths"].items():
        for method, call in methods.items():
            lines += [f"## {method.upper()} {path}", "", call.get("description") or call.get("summary", ""), ""]
            rows = [
                f"| `{one['name']}` | {one['in']} | {_type(one.get('schema', {}))} |"
                for one in call.get("parameters", ())
            ]
            body = call.get("requestBody", {}).get("content", {}).get("application/json", {}).get("schema")
            rows += [f"| body | JSON | {_type(body)} |"] if body else []
            lines += ["| parameter | where | type |", "|---|---|---|", *rows, ""] if rows else []
            answers = [f"{code} {one['description']}" for code, one in call["responses"].items()]
            lines += [f"Answers: {', '.join(answers)}.", ""]
    for name, definition in schema["components"]["schemas"].items():
        if "properties" in definition:
            lines += [f"## {name}", "", *_about(definition), *_fields(definition), ""]
    return "\n".join(lines)


def openapi() -> dict[str, Any]:
    """The document that the server gives at `/openapi.json`."""
    from stucksolver.passenger.roles import Tokens
    from stucksolver.passenger.server.app import make_app
    from stucksolver.passenger.server.board import Board

    return make_app(Board(), Tokens()).openapi()


def _cell(text: str) -> str:
    return str(text).replace("\\|", "|").replace("|", "\\|").replace("[", "\\[").replace("\n", " ")
