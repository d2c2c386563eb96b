"""The sources of a user's function: its module, and what that imports from the same folder or package."""

from __future__ import annotations

import ast
import os
import types
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Any

from .files import read_file
from .provenance import digest

MAX_SOURCE_SIZE = 1 << 20
"""Largest source file of a plugin [bytes]; chosen, fifty times that of a long module."""

MAX_SOURCES = 1000
"""Largest number of source files that a digest covers; chosen."""


@dataclass(frozen=True, slots=True)
class Sources:
    """Sources of a function.

    Attributes:
        digest: Digest of the names and bytes.
        stamps: Size and time of change of each file.
    """

    digest: str
    stamps: dict[str, tuple[int, int]]

    def changed(self) -> bool:
        """Return whether a file has changed since."""
        return any(_stamp(file) != stamp for file, stamp in self.stamps.items())


def module_sources(module: str, spec: ModuleSpec, in_folder: bool) -> Sources:
    """Return the sources of a module with a dotted name.

    They are its file, the files of the packages around it, and what these import by a statement. Imports count from the
    same package or, for a module in a folder of plugins, from that folder. Computed imports are not found.

    Args:
        module: Dotted name.
        spec: Module or package with the first part of the name.
        in_folder: Whether it lies in a folder of plugins.
    """
    top = module.partition(".")[0]
    places = spec.submodule_search_locations
    root = Path(next(iter(places))).parent if places else Path(str(spec.origin)).parent
    found: dict[str, Path] = {}
    waiting = [module]
    while waiting and len(found) < MAX_SOURCES:
        name = waiting.pop()
        for part in _with_packages(name):
            if part in found or not (in_folder or part.partition(".")[0] == top):
                continue
            file = _file(root, part)
            if file is not None:
                found[part] = file
                waiting += _imports(file, part)
    if not found and spec.origin and os.path.isfile(spec.origin):
        found[module] = Path(spec.origin)  # without a source, such as a compiled module
    return _sources(found)


def code_sources(function: Callable[..., Any]) -> Sources:
    """Return the sources of a function of this process: its file, or its code if no file holds it."""
    code = function.__code__
    file = Path(code.co_filename)
    if file.is_file():
        return _sources({"": file})
    return Sources(digest(_code_parts(code)), {})


def _sources(files: dict[str, Path]) -> Sources:
    stamps = {str(file): _stamp(str(file)) for file in files.values()}
    parts = [(name, read_file(file, MAX_SOURCE_SIZE, "of Python")) for name, file in sorted(files.items())]
    return Sources(digest(parts), stamps)


def _stamp(file: str) -> tuple[int, int]:
    try:
        status = os.stat(file)
    except OSError:
        return (0, 0)
    return (status.st_size, status.st_mtime_ns)


def _with_packages(name: str) -> Iterator[str]:
    """Yield the dotted names of the packages around a module, and its own."""
    parts = name.split(".")
    for length in range(1, len(parts) + 1):
        yield ".".join(parts[:length])


def _file(root: Path, name: str) -> Path | None:
    place = root.joinpath(*name.split("."))
    for file in (place / "__init__.py", place.with_name(f"{place.name}.py")):
        if file.is_file():
            return file
    return None


def _imports(file: Path, name: str) -> list[str]:
    """Return the dotted names that a module may import; names of functions are among them, and have no file."""
    try:
        tree = ast.parse(read_file(file, MAX_SOURCE_SIZE, "of Python"))
    except (SyntaxError, ValueError, RecursionError):
        return []
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    found: list[str] = []
    for node in _statements(tree):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            around = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join(filter(None, [*around, node.module]))
            found += [base, *(f"{base}.{alias.name}" for alias in node.names)] if base else []
            if not base:
                found += [alias.name for alias in node.names]
    return found


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all parts of a tree, without what is for type checkers alone."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        if not (isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")):
            waiting += ast.iter_child_nodes(node)


def _code_parts(code: types.CodeType) -> Iterable[tuple[str, bytes]]:
    """Yield what a function without a file computes: its instructions, names and constants."""
    yield "code", code.co_code
    yield "names", repr((code.co_names, code.co_varnames)).encode()
    for value in code.co_consts:
        if isinstance(value, types.CodeType):
            yield from _code_parts(value)
        else:
            yield "constant", repr(value).encode()
