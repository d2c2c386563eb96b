"""Object files in TOML: read, checked key by key, and written."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ..exceptions import ConfigurationError
from ..files import read_toml
from .contact import Surface, restitution_for_mass
from .hull import Hull
from .net import Net
from .object_model import SMOOTH, ObjectModel


def subtable(keys: Mapping[str, Any], key: str, valid: tuple[str, ...] | None) -> dict[str, Any]:
    """Return the table `key` of `keys`, empty where it is absent.

    Raises:
        ConfigurationError: where it is no table, or holds a key that is not among `valid`, if that is given.
    """
    table = keys.get(key, {})
    if not isinstance(table, Mapping):
        raise ConfigurationError(f"{key} = {table!r:.80} must be a table")
    if valid is not None:
        refuse_unknown(table, valid, f"[{key}]")
    return dict(table)


def refuse_unknown(keys: Mapping[str, Any], valid: tuple[str, ...], what: str) -> None:
    """Refuse a key that is not valid; `what` says of what.

    Raises:
        ConfigurationError: names the key and the nearest valid one, or all.
    """
    for key in keys:
        if key not in valid:
            close = get_close_matches(key, valid, n=1)
            remedy = f"did you mean {close[0]!r}?" if close else f"valid keys are {', '.join(valid)}"
            raise ConfigurationError(f"{what} has no key {key!r}; {remedy}")


def number(keys: Mapping[str, Any], key: str, bounds: tuple[float, float], unit: str, prefix: str = "") -> float:
    """Return the number `key`, which must lie within `bounds`; `prefix` is that of the table it stands in.

    Raises:
        ConfigurationError: where it is missing, no number, or outside.
    """
    if key not in keys:
        raise ConfigurationError(f"the key {prefix + key!r} is missing")
    return _within(keys[key], prefix + key, bounds, unit)


def numbers(keys: Mapping[str, Any], key: str, bounds: tuple[float, float]) -> list[float]:
    """Return the three lengths [m] of the list `key`, each within `bounds`.

    Raises:
        ConfigurationError: where it is missing, no such list, or a length is outside.
    """
    values = keys.get(key)
    if not isinstance(values, list | tuple) or len(values) != 3:
        raise ConfigurationError(f"{key} = {values!r:.80} must be a list of 3 lengths in m")
    return [_within(value, f"{key}[{i}]", bounds, "m") for i, value in enumerate(values)]


def _within(value: Any, key: str, bounds: tuple[float, float], unit: str) -> float:
    low, high = bounds
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not math.isfinite(value) or not low <= value <= high:
        allowed = f"{low:g} to {high:g} {unit}".rstrip()
        raise ConfigurationError(f"{key} = {value!r:.80} must be a number from {allowed}")
    return float(value)


VARIANTS = ("real", "sim", "literal")
SIZES = {
    "sphere": ("radius",),
    "ellipsoid": ("radii",),
    "capsule": ("radius", "length"),
    "cylinder": ("radius", "length"),
    "box": ("edges",),
    "mesh": ("file", "unit", "scale"),
}
"""The keys of each shape. A capsule's length is that from end to end, caps included."""

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
WIDTHS = (0.002, 0.5)
"""Whole widths that an object may have [m]: a contact of 300 rad/s needs a body, and a hand must get around it."""
MASSES = (0.001, 5.0)
"""As `pile.mass` [kg]."""
INERTIA_FACTORS = (0.1, 2.0)
"""2 is a thin tube about its axis; a thin ball has 5/3."""
NET_LOOPS = (0.01, 3.0)
LARGEST_NET = 12
_COMMON = ("shape", "mass", "inertia_factor", "friction", "restitution", "net", "source")
_FRICTION = {"lateral": SMOOTH.lateral, "spinning": SMOOTH.spinning, "rolling": SMOOTH.rolling}


def read_object(file: Path, variant: str = "real") -> ObjectModel:
    """Read one kind of object; a table named like the variant replaces keys above it.

    The keys above all tables are the variant "real". `docs/objects.md` lists them.

    Raises:
        ConfigurationError: one sentence that names the file, the key and what is allowed.
    """
    table = read_toml(file, "of an object")
    try:
        return build_object(table, file.stem, variant, file.parent)
    except ConfigurationError as error:
        raise ConfigurationError(f"{file}: {error}") from None


def write_object(path: str | Path, /, **keys: Any) -> Path:
    """Check the keys of an object and write them as TOML, for `pile.object`; return the file's path.

    Args:
        path: where to; it ends in `.toml`.
        keys: as in a file; `friction`, `net` and the variants are dictionaries.

    Raises:
        ConfigurationError: where `read_object` would refuse the file, or the place cannot be written.
    """
    path = Path(path)
    if path.suffix != ".toml":
        raise ConfigurationError(f"{path}: the file of an object must end in .toml")
    for variant in ("real", *(name for name in VARIANTS if name in keys)):
        build_object(keys, path.stem, variant, path.parent)
    tables = {key: value for key, value in keys.items() if isinstance(value, Mapping)}
    lines = [f"{key} = {_toml(value)}" for key, value in keys.items() if key not in tables]
    for name, table in tables.items():
        lines += ["", f"[{name}]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    try:
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be written: {error.strerror}") from None
    return path


def build_object(table: Mapping[str, Any], name: str, variant: str, folder: Path) -> ObjectModel:
    """Return the kind that the keys of a file describe; a mesh's file starts at `folder`.

    Raises:
        ConfigurationError: one sentence that names the key and what is allowed.
    """
    if variant != "real" and variant not in table:
        have = ["real", *(other for other in VARIANTS[1:] if other in table)]
        raise ConfigurationError(f"has no variant {variant!r}; pile.variant can be {' or '.join(map(repr, have))}")
    keys = {key: value for key, value in table.items() if key not in VARIANTS} | subtable(table, variant, None)
    shape = keys.get("shape")
    if not isinstance(shape, str) or shape not in SIZES:
        raise ConfigurationError(f"shape = {shape!r:.80} must be one of {', '.join(map(repr, SIZES))}")
    valid = (*_COMMON, *SIZES[shape])
    for other in VARIANTS:
        refuse_unknown(subtable(table, other, None), valid, f"[{other}] of a {shape}")
    refuse_unknown(keys, valid, f"a {shape}")
    mass = number(keys, "mass", MASSES, "kg")
    hull = _hull(keys, folder) if shape == "mesh" else None
    half_size = hull.half_extents if hull else _half_size(keys, shape)
    bounces = "restitution" not in keys
    bounce = restitution_for_mass(mass) if bounces else number(keys, "restitution", (0.0, 1.0), "")
    friction = _FRICTION | subtable(keys, "friction", tuple(_FRICTION))
    lateral, spinning, rolling = (number(friction, key, (0.0, 5.0), "", "friction.") for key in _FRICTION)
    kind = ObjectModel(
        name=name,
        shape=shape,  # type: ignore[arg-type]
        half_size=half_size,
        mass=mass,
        inertia_factor=number({"inertia_factor": 1.0, **keys}, "inertia_factor", INERTIA_FACTORS, ""),
        surface=Surface(lateral, spinning, rolling, bounce, rank=1),
        bounces_by_mass=bounces,
        hull=hull,
    )
    return _tied(kind, keys) if "net" in keys else kind


def _tied(kind: ObjectModel, keys: Mapping[str, Any]) -> ObjectModel:
    table = subtable(keys, "net", ("members", "loop"))
    members = table.get("members")
    if not isinstance(members, int) or isinstance(members, bool) or not 2 <= members <= LARGEST_NET:
        raise ConfigurationError(f"net.members = {members!r:.80} must be an integer from 2 to {LARGEST_NET}")
    net = Net(members, number(table, "loop", NET_LOOPS, "m", "net."))
    least = net.least_loop(kind.flank_radius)
    if net.loop < least:
        raise ConfigurationError(
            f"net.loop = {net.loop:g} is too short for {members} objects side by side; at least {least:.3f} m is needed"
        )
    return replace(kind, net=net)


def _half_size(keys: Mapping[str, Any], shape: str) -> tuple[float, ...]:
    half = (0.5 * WIDTHS[0], 0.5 * WIDTHS[1])
    if shape == "box":
        return tuple(0.5 * edge for edge in numbers(keys, "edges", WIDTHS))
    if shape == "ellipsoid":
        return tuple(numbers(keys, "radii", half))
    radius = number(keys, "radius", half, "m")
    if shape == "sphere":
        return (radius,)
    length = number(keys, "length", WIDTHS, "m")
    if shape == "cylinder":
        return radius, 0.5 * length
    if length <= 2.0 * radius:
        raise ConfigurationError(
            f"length = {length:g} must be more than twice the radius, because it is that of the whole capsule; "
            "a ball is a sphere"
        )
    return radius, 0.5 * length - radius


def _hull(keys: Mapping[str, Any], folder: Path) -> Hull:
    file, unit = keys.get("file"), keys.get("unit")
    if not isinstance(file, str) or not file:
        raise ConfigurationError(f"file = {file!r:.80} must be the path of an STL or OBJ file")
    if not isinstance(unit, str) or unit not in UNITS:
        raise ConfigurationError(
            f"unit = {unit!r:.80} must be one of {', '.join(map(repr, UNITS))}; a mesh does not say what it is drawn in"
        )
    scale = number({"scale": 1.0, **keys}, "scale", (1e-4, 1e4), "")
    hull = Hull.load(folder / file, UNITS[unit] * scale)
    least, most = 2.0 * min(hull.half_extents), 2.0 * max(hull.half_extents)
    if not WIDTHS[0] <= least <= most <= WIDTHS[1]:
        raise ConfigurationError(
            f"the mesh measures {least:.3g} to {most:.3g} m across, and {WIDTHS[0]:g} to {WIDTHS[1]:g} m are allowed; "
            "look at unit and scale"
        )
    return hull


def _toml(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    return repr(float(value)) if isinstance(value, float) else str(value)
