"""Functions of a user, named as `module:function`: plans, measures, and builders of hands.

A module comes from an installed package, or from a folder that the command names by `--plugins DIR`. It never comes
from the current folder, `PYTHONPATH`, the standard library, or the folder of the file that names it. A scenario from a
stranger therefore runs no code of its own.
"""

from __future__ import annotations

import importlib
import inspect
import os
import site
import sys
import sysconfig
import threading
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from typing import Any, NamedTuple

from .exceptions import ConfigurationError, remedy_for
from .plugin_sources import Sources, code_sources, module_sources

PACKAGE = __name__.partition(".")[0]
"""This package, whose functions may be named as well."""

MAX_SHOWN_FOLDERS = 5
"""Largest number of folders that an error names; chosen."""


class Plugin(NamedTuple):
    """A function of a user.

    Attributes:
        function: The function.
        sources: Sources of its module, which its digest covers.
    """

    function: Callable[..., Any]
    sources: Sources


_lock = threading.RLock()
_folders: tuple[str, ...] = ()
_added: tuple[str, ...] = ()
_loaded: dict[str, Plugin] = {}
_adopted: dict[str, Plugin] = {}


def is_plugin(name: str) -> bool:
    """Return whether a name has the form `module:function`."""
    return ":" in name


def use_plugins(folders: Iterable[str | Path]) -> tuple[str, ...]:
    """Take functions from these folders, too, and from no others; return their absolute paths.

    Modules of folders that are no longer named are forgotten, and so are modules whose file has changed. A folder that
    Python searches anyway stays as it is, with its modules.

    Raises:
        ConfigurationError: A name is not that of a folder.
    """
    global _folders, _added  # One list for the process, as for the modules that Python has loaded.
    if isinstance(folders, str | Path):
        folders = (folders,)
    found = tuple(dict.fromkeys(_folder(folder) for folder in folders))
    with _lock:
        if found != _folders or any(plugin.sources.changed() for plugin in _loaded.values()):
            _forget(_added)
            sys.path[:] = [entry for entry in sys.path if entry not in _added]
            # For imports inside of functions; those at the top of a module see `_import_path`.
            _added = tuple(folder for folder in found if folder not in sys.path)
            sys.path.extend(_added)
            _folders = found
            importlib.invalidate_caches()
    return found


def plugin_folders() -> tuple[str, ...]:
    """Return the folders of `use_plugins`, as absolute paths; workers need the same."""
    return _folders


def load_plugin(name: str, key: str, parameters: Sequence[str], *, named: bool = False) -> Plugin:
    """Return the function that a user calls `module:function`.

    Args:
        name: Module and function, such as "my_package.my_module:plan".
        key: What names the function, for errors, such as "program".
        parameters: Names of the arguments with which the function is called.
        named: Whether its parameters must have these very names. A file that names a function then cannot run
            whatever function an installed package happens to have.

    Raises:
        ConfigurationError: There is no such module or function, it cannot be imported, or it has other parameters.
    """
    shown = f"{key} = {name!r:.120}"
    with _lock:
        plugin = _adopted.get(name) or _loaded.get(name)
        if plugin is None:
            plugin = _loaded[name] = _load(name, shown)
    _check_parameters(plugin.function, shown, parameters, named)
    return plugin


def plugin_digest(name: str, key: str, parameters: Sequence[str], *, named: bool = False) -> str:
    """Return a digest of the sources of a function; see `load_plugin`."""
    return load_plugin(name, key, parameters, named=named).sources.digest


def adopt(function: Callable[..., Any], key: str, parameters: Sequence[str], *, named: bool = False) -> str:
    """Make a function of this process known as `module:function`, and return this name.

    Raises:
        ConfigurationError: The function has other parameters, or its digest would not cover all that it computes from.
    """
    kind = f"{key} = {function!r:.80}"
    if not inspect.isfunction(function) or function.__name__ == "<lambda>":
        raise ConfigurationError(f"{kind} must be a function that `def` made; its source counts in config_hash")
    if function.__closure__:
        around = ", ".join(function.__code__.co_freevars)
        raise ConfigurationError(
            f"{kind} uses {around} of the function around it, which its digest does not cover; make a function of a "
            "module, with constants of the module"
        )
    name = f"{function.__module__}:{function.__qualname__}"
    _check_parameters(function, f"{key} = {name!r:.120}", parameters, named)
    with _lock:
        _adopted[name] = Plugin(function, code_sources(function))
    return name


def explain(error: BaseException) -> str:
    """Return the type and text of an error in a user's function, and the line of a file that raised it."""
    text = " ".join(str(error).split())
    if isinstance(error, SyntaxError):
        return f"{type(error).__name__}: {error.msg} ({_short(error.filename)}, line {error.lineno})"
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not _is_machinery(frame.filename)]
    where = f" ({_short(frames[-1].filename)}, line {frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}{f': {text}' if text else ''}{where}"


def _folder(folder: str | Path) -> str:
    path = Path(os.path.abspath(folder))
    if not path.is_dir():
        raise ConfigurationError(f"--plugins {str(folder)!r:.200}: is no folder; give the folder of your module")
    return str(path)


def _load(name: str, shown: str) -> Plugin:
    module, colon, attribute = name.partition(":")
    parts = [*module.split("."), attribute]
    if not colon or not all(part.isidentifier() and not part.startswith("__") for part in parts):
        raise ConfigurationError(f"{shown} is not of the form module:function, as in my_package.my_module:plan")
    spec = _find(parts[0])
    if spec is None:
        raise ConfigurationError(f"{shown}: no module {parts[0]!r} is in {_where()}; name its folder by --plugins DIR")
    _check_not_loaded_from_elsewhere(parts[0], spec, shown)
    # Before the import, so that the digest never covers more than what is imported.
    sources = module_sources(module, spec, _in_folders(spec))
    try:
        with _import_path():
            loaded = importlib.import_module(module)
    except (Exception, SystemExit) as error:
        if isinstance(error, ModuleNotFoundError) and error.name and module.startswith(error.name):
            raise ConfigurationError(f"{shown}: {spec.name!r} has no module {module!r}; see its folder") from error
        raise ConfigurationError(f"{shown}: the module cannot be imported: {explain(error)}") from error
    found = getattr(loaded, attribute, None)
    if not callable(found):
        own = [each for each, value in vars(loaded).items() if callable(value) and not each.startswith("_")]
        remedy = remedy_for(attribute, own, f"define `def {attribute}(...)` in it")
        raise ConfigurationError(f"{shown}: the module {module!r} has no function {attribute!r}; {remedy}")
    return Plugin(found, sources)


def _find(top: str) -> ModuleSpec | None:
    """Return the module or package with a name without dots, wherever a plugin may come from."""
    if top == PACKAGE:
        return sys.modules[PACKAGE].__spec__
    spec = PathFinder.find_spec(top, [*_folders, *_installed()])
    for finder in sys.meta_path if spec is None else ():
        # setuptools makes such a finder for a package that is installed with `pip install -e`.
        if str(getattr(finder, "__module__", "")).startswith("__editable__"):
            spec = finder.find_spec(top, None)
            if spec is not None:
                break
    return spec


@cache
def _installed() -> tuple[str, ...]:
    """Return the folders of installed packages, and those that their `.pth` files name."""
    places = [sysconfig.get_path("purelib"), sysconfig.get_path("platlib"), *site.getsitepackages()]
    if site.ENABLE_USER_SITE:
        places.append(site.getusersitepackages())
    found: dict[str, None] = {}
    for place in dict.fromkeys(places):
        found[place] = None
        for file in sorted(Path(place).glob("*.pth")):
            lines = file.read_text(encoding="utf-8", errors="replace").splitlines()
            entries = (os.path.join(place, line.strip()) for line in lines if line.strip() and line[0] != "#")
            found |= dict.fromkeys(entry for entry in entries if os.path.isdir(entry))
    # Code in a `.pth` file may add more, such as that of Pinocchio's packages.
    roots = tuple(f"{place}{os.sep}" for place in places)
    found |= dict.fromkeys(entry for entry in sys.path if entry.startswith(roots))
    return tuple(found)


@contextmanager
def _import_path() -> Iterator[None]:
    """Let imports see the standard library, the folders of plugins and installed packages alone; write no bytecode."""
    before, writes = sys.path[:], sys.dont_write_bytecode
    library = {os.path.realpath(sysconfig.get_path(name)) for name in ("stdlib", "platstdlib")}
    standard = [
        entry
        for entry in before
        if os.path.realpath(entry or os.curdir) in library
        or os.path.basename(entry) == "lib-dynload"
        or (entry.endswith(".zip") and os.path.dirname(os.path.realpath(entry)) in map(os.path.dirname, library))
    ]
    sys.path[:], sys.dont_write_bytecode = [*standard, *_folders, *_installed()], True
    try:
        yield
    finally:
        sys.path[:], sys.dont_write_bytecode = before, writes


def _check_not_loaded_from_elsewhere(top: str, spec: ModuleSpec, shown: str) -> None:
    loaded = sys.modules.get(top)
    if loaded is None:
        return
    there = getattr(getattr(loaded, "__spec__", None), "origin", None) or getattr(loaded, "__file__", None)
    if not there or not spec.origin or os.path.realpath(there) != os.path.realpath(spec.origin):
        raise ConfigurationError(
            f"{shown}: another module {top!r} is already loaded from {there or 'Python itself'}; rename yours"
        )


def _in_folders(spec: ModuleSpec) -> bool:
    places = [spec.origin, *(spec.submodule_search_locations or ())]
    return any(str(place).startswith(f"{folder}{os.sep}") for place in places for folder in _folders)


def _forget(folders: Sequence[str]) -> None:
    """Forget the modules of some folders, so that the next use imports them anew."""
    _loaded.clear()
    for name, module in list(sys.modules.items()):
        file = getattr(module, "__file__", None)
        places = [file] if file else list(getattr(module, "__path__", ()))
        if any(str(place).startswith(f"{folder}{os.sep}") for place in places for folder in folders):
            del sys.modules[name]


def _check_parameters(function: Callable[..., Any], shown: str, parameters: Sequence[str], named: bool) -> None:
    wanted = f"({', '.join(parameters)})"
    try:
        signature = inspect.signature(function)
        bound = signature.bind(*parameters)
    except (TypeError, ValueError):
        has = _shown_parameters(function)
        raise ConfigurationError(f"{shown} takes {has}, but it is called with {wanted}; let it take these") from None
    if named and list(bound.arguments) != list(parameters):
        raise ConfigurationError(f"{shown} takes {_shown_parameters(function)}; its parameters must be called {wanted}")


def _shown_parameters(function: Callable[..., Any]) -> str:
    try:
        return f"({', '.join(inspect.signature(function).parameters)})"
    except (TypeError, ValueError):
        return "no arguments that Python knows of"


def _where() -> str:
    if not _folders:
        return "the installed packages"
    more = f" and {len(_folders) - MAX_SHOWN_FOLDERS} more" if len(_folders) > MAX_SHOWN_FOLDERS else ""
    return f"{', '.join(_folders[:MAX_SHOWN_FOLDERS])}{more} or the installed packages"


def _is_machinery(file: str) -> bool:
    return file.startswith("<") or file == __file__ or os.sep + "importlib" + os.sep in file


def _short(file: str | None) -> str:
    return os.path.basename(file) if file else "?"
