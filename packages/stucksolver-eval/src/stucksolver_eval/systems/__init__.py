"""The arms: the driver alone, timers, or StuckSolver."""

from stucksolver_eval.systems.factory import ArmError, carries_camera, make_arm
from stucksolver_eval.systems.system_under_test import Arm, ArmLog

__all__ = ["Arm", "ArmError", "ArmLog", "carries_camera", "make_arm"]
