"""`stucksolver prompt`: what would be sent to a language model for a scene."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from stucksolver.cli.errors import UsageError
from stucksolver.reason.llm.prompt import messages, prompt_name
from stucksolver.reason.llm.schema import decide_tool
from stucksolver.scene import Scene


def add_options(parser: argparse.ArgumentParser) -> None:
    """What the command is told."""
    parser.add_argument("scene", type=Path, metavar="SCENE.json", help="a scene, or a record of an intervention")
    parser.add_argument("--json", action="store_true", help="messages and tool as JSON, the image left out")


def run(options: argparse.Namespace) -> int:
    """Raises `UsageError` for a file that holds no scene."""
    scene = read_scene(options.scene)
    turns, tool = messages(scene), decide_tool(scene)
    if options.json:
        told = [{"role": turn.role, "text": turn.text} for turn in turns]
        print(json.dumps({"messages": told, "tool": {"name": tool.name, "parameters": tool.parameters}}, indent=1))
        return 0
    print(f"prompt version {prompt_name()}")
    for turn in turns:
        print(f"\n--- {turn.role}\n{turn.text}")
    if scene.image is not None:
        print(f"[front camera, {scene.image.width}x{scene.image.height}, {len(scene.image.jpeg)} bytes of JPEG]")
    print(f"\n--- function {tool.name}: {tool.description}\n{json.dumps(tool.parameters, separators=(',', ':'))}")
    return 0


def read_scene(path: Path) -> Scene:
    """A scene's JSON, or the first scene in a record's lines."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{path} cannot be read: {error}") from error
    found = _candidates(text)
    if not found:
        raise UsageError(f"{path} holds no scene; give the JSON of a Scene, or a record of an intervention")
    try:
        return Scene.model_validate_json(json.dumps(found[0]))
    except ValidationError as error:
        problem = error.errors()[0]
        where = ".".join(str(part) for part in problem["loc"]) or "the whole"
        raise UsageError(f"{path} holds no scene that can be read: {where}: {problem['msg']}") from error


def _candidates(text: str) -> list[Any]:
    whole = _json(text)
    if isinstance(whole, dict) and "ego" in whole:
        return [whole]
    return _scenes_in([whole] if whole is not None else [_json(line) for line in text.splitlines()])


def _json(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return None


def _scenes_in(values: list[Any]) -> list[Any]:
    """Scenes that stand under the key `scene` at any depth, in order."""
    found: list[Any] = []
    for value in values:
        if isinstance(value, dict):
            if isinstance(value.get("scene"), dict):
                found.append(value["scene"])
            found += _scenes_in(list(value.values()))
        elif isinstance(value, list):
            found += _scenes_in(value)
    return found
