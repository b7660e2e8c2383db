"""The systems under test: the driver alone, timers, or StuckSolver."""

from stucksolver_eval.systems.factory import SystemSpecError, carries_camera, make_arm
from stucksolver_eval.systems.system_under_test import SystemLog, SystemUnderTest

__all__ = ["SystemLog", "SystemSpecError", "SystemUnderTest", "carries_camera", "make_arm"]
