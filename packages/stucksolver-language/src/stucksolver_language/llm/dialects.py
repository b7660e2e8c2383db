"""Formats in which a function call is requested, and how strictly it is demanded."""

from __future__ import annotations

from enum import Enum


class Dialect(Enum):
    """How the function call is requested."""

    STRICT_TOOL = "strict"
    TOOL = "tool"
    JSON_SCHEMA = "schema"
    PROSE = "prose"


class ToolChoice(Enum):
    """How strictly a function call is demanded."""

    NAMED = "named"
    REQUIRED = "required"
    AUTO = "auto"
