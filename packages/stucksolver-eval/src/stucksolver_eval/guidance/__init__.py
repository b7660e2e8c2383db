"""Utterances of a passenger by route, and their times."""

from stucksolver_eval.guidance.script import GuidanceError, Script, ScriptLine, ScriptTrigger, read_script
from stucksolver_eval.guidance.script_player import ScriptPlayer

__all__ = ["GuidanceError", "Script", "ScriptLine", "ScriptPlayer", "ScriptTrigger", "read_script"]
