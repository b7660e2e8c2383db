"""Recording what happens in a world, reporting on it, and replaying it. The format is carlette's own."""

from carlette.recorder.folder import default_folder, make_room, path_in
from carlette.recorder.log_file import LogFile, read_tape
from carlette.recorder.recorder import LogRecorder
from carlette.recorder.replay import Replay, ReplayOptions

__all__ = ["LogFile", "LogRecorder", "Replay", "ReplayOptions", "default_folder", "make_room", "path_in", "read_tape"]
