"""Prevents the C library from retaining unused memory.

One thread builds a town's scenery, another draws it, a third scans it, and it is freed when the next town is loaded. By
default each thread of glibc frees into its own arena, and only the end of an arena is returned. So a server that loaded
one town after another grew by 5 MB each time without using more. With other C libraries this module does nothing.
"""

from __future__ import annotations

import ctypes
from functools import lru_cache
from typing import Any

_ARENA_MAX = -8
"""`M_ARENA_MAX` of glibc's `malloc.h`."""


def use_single_arena() -> None:
    """Let all threads reuse the memory that any of them frees. Call this before other threads start."""
    mallopt = getattr(_libc(), "mallopt", None)
    if mallopt is not None:
        mallopt(_ARENA_MAX, 1)


def release_memory() -> None:
    """Return free pages to the system. This takes milliseconds, so call it after longer work."""
    trim = getattr(_libc(), "malloc_trim", None)
    if trim is not None:
        trim(0)


@lru_cache(maxsize=1)
def _libc() -> Any:
    return ctypes.CDLL(None)
