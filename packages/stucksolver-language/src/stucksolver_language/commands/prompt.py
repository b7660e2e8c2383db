"""`stucksolver prompt`: prints the prompt that a language model gets for a scene."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from stucksolver.commands.arguments import add_json, print_json
from stucksolver.commands.errors import UsageError
from stucksolver.record.hash_chain import RecordError
from stucksolver.record.record_file import image_of
from stucksolver.scene import Scene
from stucksolver.scene.json_text import JsonError, read_json
from stucksolver_language.llm.prompt import messages, prompt_name
from stucksolver_language.llm.tool_schema import decide_tool


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument("scene", type=Path, metavar="SCENE.json", help="a scene, or a record of an intervention")
    add_json(parser, '{"messages": [{"role", "text"}], "tool": {"name", "parameters"}}, without the image')


def run(options: argparse.Namespace) -> int:
    """Print the prompt and the function that the model may call. Returns 0. Raises `UsageError`."""
    scene = read_scene(options.scene)
    turns, tool = messages(scene), decide_tool(scene)
    if options.json:
        plain_turns = [{"role": turn.role, "text": turn.text} for turn in turns]
        print_json({"messages": plain_turns, "tool": {"name": tool.name, "parameters": tool.parameters}})
        return 0
    print(f"prompt version {prompt_name()}")
    for turn in turns:
        print(f"\n--- {turn.role}\n{turn.text}")
    print("[the plans that the search finds are listed here in a drive: they need the surroundings and the guard]")
    if scene.image is not None:
        print(f"[front camera, {scene.image.width}x{scene.image.height}, {len(scene.image.jpeg)} bytes of JPEG]")
    print(f"\n--- function {tool.name}: {tool.description}\n{json.dumps(tool.parameters, separators=(',', ':'))}")
    return 0


def read_scene(path: Path) -> Scene:
    """Read a scene from its JSON, or the first scene from a record. Raises `UsageError`."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read file: {path}: {error}") from error
    found = _candidates(text)
    if not found:
        raise UsageError(f"no scene in file: {path}. Give the JSON of a Scene, or a record of an intervention")
    try:
        return Scene.model_validate_json(json.dumps(_with_image(found[0], path)))
    except ValidationError as error:
        problem = error.errors()[0]
        where = ".".join(str(part) for part in problem["loc"]) or "the scene"
        raise UsageError(f"invalid scene in file: {path}: {where}: {problem['msg']}") from error


def _with_image(scene: dict[str, Any], record: Path) -> dict[str, Any]:
    """Return a scene with its image from the folder next to the record, or without one that is missing."""
    image = scene.get("image")
    if not isinstance(image, dict) or "jpeg" in image:
        return scene
    try:
        return {**scene, "image": image_of(image, record.parent)}
    except (RecordError, KeyError) as error:
        print(f"note: shown without the image: {error}", file=sys.stderr)
        return {**scene, "image": None}


def _candidates(text: str) -> list[Any]:
    whole = _json(text)
    if isinstance(whole, dict) and "ego" in whole:
        return [whole]
    return _scenes_in([whole] if whole is not None else [_json(line) for line in text.splitlines()])


def _json(text: str) -> Any:
    try:
        return read_json(text)
    except JsonError:
        # Text that is not JSON has no candidates; the caller reports that the file has no scene.
        return None


def _scenes_in(values: list[Any]) -> list[Any]:
    """Return the objects under the key `scene` at any depth, in order."""
    found: list[Any] = []
    for value in values:
        if isinstance(value, dict):
            if isinstance(value.get("scene"), dict):
                found.append(value["scene"])
            found += _scenes_in(list(value.values()))
        elif isinstance(value, list):
            found += _scenes_in(value)
    return found
