"""What a passenger says on which route, and when."""

from stucksolver_eval.guidance.script import GuidanceError, Script, ScriptLine, ScriptTrigger, read_script
from stucksolver_eval.guidance.script_player import ScriptPlayer

__all__ = ["GuidanceError", "Script", "ScriptLine", "ScriptPlayer", "ScriptTrigger", "read_script"]
