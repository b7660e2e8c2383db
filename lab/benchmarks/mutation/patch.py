"""Replaces the source of a module: in the running process, or before it is imported."""

from __future__ import annotations

import gc
import importlib.abc
import importlib.machinery
import sys
from collections import defaultdict
from collections.abc import Iterator
from functools import _lru_cache_wrapper
from pathlib import Path
from types import CodeType, FunctionType, ModuleType

Key = tuple[str, str, int]


class Functions:
    """All functions of the process, by the position of their code."""

    def __init__(self) -> None:
        self._found: dict[Key, list[FunctionType]] = defaultdict(list)
        self._caches: list[_lru_cache_wrapper[object]] = []
        for obj in gc.get_objects():
            if type(obj) is FunctionType:
                self._found[_key(obj.__code__)].append(obj)
            elif type(obj) is _lru_cache_wrapper:
                self._caches.append(obj)

    def change(self, file: str, before: bytes, after: bytes) -> int:
        """Give the functions of a file the code of a changed source; return how many changed."""
        changed = 0
        old, new = (compile(source, file, "exec", dont_inherit=True) for source in (before, after))
        for was, now in _pairs(old, new):
            for function in self._found[_key(was)]:
                if function.__code__.co_code == was.co_code and function.__code__.co_consts == was.co_consts:
                    function.__code__ = now
                    changed += 1
        for cache in self._caches:
            cache.cache_clear()
        return changed


def _key(code: CodeType) -> Key:
    return code.co_filename, code.co_qualname, code.co_firstlineno  # type: ignore[attr-defined,unused-ignore]


def _pairs(old: CodeType, new: CodeType) -> Iterator[tuple[CodeType, CodeType]]:
    """Yield the outermost functions, before and after, whose code differs."""
    inner = ([const for const in code.co_consts if isinstance(const, CodeType)] for code in (old, new))
    for was, now in zip(*inner, strict=True):
        if was == now:
            continue
        if was.co_flags & 0x2:  # CO_NEWLOCALS: a function, not a class's body
            yield was, now
        else:
            yield from _pairs(was, now)


class Instead(importlib.abc.MetaPathFinder):
    """Imports one module from a changed source."""

    def __init__(self, file: Path, source: bytes) -> None:
        self._file = file
        self._source = source

    def find_spec(
        self, name: str, path: object = None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Find the module as usual, but load the changed source."""
        spec = importlib.machinery.PathFinder.find_spec(name, path)  # type: ignore[arg-type]
        if spec is None or spec.origin != str(self._file):
            return None
        spec.loader = _Loader(name, str(self._file), self._source)
        return spec


class _Loader(importlib.machinery.SourceFileLoader):
    def __init__(self, name: str, path: str, source: bytes) -> None:
        super().__init__(name, path)
        self._changed = source

    def get_code(self, fullname: str) -> CodeType:
        """Compile the changed source; nothing is cached."""
        return compile(self._changed, self.path, "exec", dont_inherit=True)


def import_instead(file: Path, source: bytes) -> None:
    """Import a module from a changed source. It must not have been imported yet."""
    sys.meta_path.insert(0, Instead(file, source))
