"""What a passenger says on which route, and when."""

from stucksolver_eval.guidance.script import GuidanceError, Line, Script, When, read_script
from stucksolver_eval.guidance.script_player import Speaker

__all__ = ["GuidanceError", "Line", "Script", "Speaker", "When", "read_script"]
