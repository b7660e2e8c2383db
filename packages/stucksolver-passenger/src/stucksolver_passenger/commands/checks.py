"""Checks of `stucksolver doctor` for the passenger's page."""

from __future__ import annotations

from stucksolver.commands.doctor import Check, package

CHECKS: tuple[Check, ...] = (package("fastapi", "the passenger's page", "passenger"),)
