"""Detects that the vehicle is immobilized."""

from stucksolver.detect.detector import Detector, DetectorSettings, Trigger

__all__ = ["Detector", "DetectorSettings", "Trigger"]
