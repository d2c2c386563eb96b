"""Object files in TOML: read, checked key by key, and written."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..exceptions import ConfigurationError, remedy_for
from ..files import read_toml
from ..sections import MASS_RANGE
from .contact import OBJECT_RANK, Surface, restitution_for_mass
from .hull import Hull
from .net import Net
from .object_model import SMOOTH, ObjectModel
from .solid import Solid, load_solid

VARIANTS = ("real", "sim", "literal")
"""Names of the variants, which are tables of an object file; the keys above all tables are "real". They are three
readings of the paper's Table I."""

SIZE_KEYS = {
    "sphere": ("radius",),
    "ellipsoid": ("radii",),
    "capsule": ("radius", "length"),
    "cylinder": ("radius", "length"),
    "box": ("edges",),
    "mesh": ("file", "unit", "scale", "hull"),
}
"""Keys of each shape. A capsule's length includes its caps."""

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
"""Lengths of the units of a mesh [m]."""

WIDTHS = (0.002, 0.5)
"""Range of an object's widths [m], chosen: a contact that gives way needs a minimum size, and the hand must fit around
it."""

INERTIA_FACTORS = (0.1, 2.0)
"""Range of the inertia factor [-]. A thin tube has 2 about its axis, a thin ball 5/3."""

FLAT = ("cylinder", "box", "mesh")
"""Shapes with flat faces."""

CONTACT_TIMES = (0.0, 0.02)
"""Range of the duration of a bounce [s]; chosen."""

NET_LOOPS = (0.01, 3.0)
"""Range of a net's loop [m], chosen."""

MAX_NET_MEMBERS = 12
"""Largest number of objects in one net [-], chosen."""

COMMON_KEYS = ("shape", "mass", "inertia_factor", "friction", "restitution", "contact_time", "net", "source")
"""Keys of every shape."""

DEFAULT_FRICTION = {"lateral": SMOOTH.lateral, "spinning": SMOOTH.spinning, "rolling": SMOOTH.rolling}
"""Friction of an object whose file states none."""


def read_object(file: Path, variant: str = "real") -> ObjectModel:
    """Read an object. The table of the variant replaces keys above the tables, which are the variant "real".

    `docs/objects.md` lists the keys.

    Raises:
        ConfigurationError: The file cannot be read, or a key is invalid. The error names file, key and allowed values.
    """
    table = read_toml(file, "of an object")
    try:
        return build_object(table, file.stem, variant, file.parent)
    except ConfigurationError as error:
        raise ConfigurationError(f"{file}: {error}") from None


def write_object(path: str | Path, /, **keys: Any) -> Path:
    """Check the keys of an object, write them as TOML for `pile.object`, and return the file's path.

    Args:
        path: File to write; its name ends in `.toml`.
        keys: Keys as in a file; `friction`, `net` and the variants are dictionaries.

    Raises:
        ConfigurationError: A key is invalid, or the file cannot be written.
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
    """Return the model that the keys of a file describe. The path of a mesh is relative to `folder`.

    Raises:
        ConfigurationError: A key is invalid. The error names it and the allowed values.
    """
    if variant != "real" and variant not in table:
        have = ["real", *(other for other in VARIANTS[1:] if other in table)]
        raise ConfigurationError(f"has no variant {variant!r}; pile.variant can be {' or '.join(map(repr, have))}")
    keys = {key: value for key, value in table.items() if key not in VARIANTS} | _subtable(table, variant, None)
    shape = keys.get("shape")
    if not isinstance(shape, str) or shape not in SIZE_KEYS:
        raise ConfigurationError(f"shape = {shape!r:.80} must be one of {', '.join(map(repr, SIZE_KEYS))}")
    valid = (*COMMON_KEYS, *SIZE_KEYS[shape])
    for other in VARIANTS:
        _reject_unknown(_subtable(table, other, None), valid, f"[{other}] of a {shape}")
    _reject_unknown(keys, valid, f"a {shape}")
    mass = _number(keys, "mass", MASS_RANGE, "kg")
    hull = _load_mesh(keys, folder) if shape == "mesh" else None
    half_size = hull.half_extents if hull else _half_size(keys, shape)
    bounces_by_mass = "restitution" not in keys
    restitution = restitution_for_mass(mass) if bounces_by_mass else _number(keys, "restitution", (0.0, 1.0), "")
    friction = DEFAULT_FRICTION | _subtable(keys, "friction", tuple(DEFAULT_FRICTION))
    lateral, spinning, rolling = (_number(friction, key, (0.0, 5.0), "", "friction.") for key in DEFAULT_FRICTION)
    time = _number({"contact_time": 0.0, **keys}, "contact_time", CONTACT_TIMES, "s")
    object_model = ObjectModel(
        name=name,
        shape=shape,  # type: ignore[arg-type]
        half_size=half_size,
        mass=mass,
        inertia_factor=_number({"inertia_factor": 1.0, **keys}, "inertia_factor", INERTIA_FACTORS, ""),
        surface=Surface(lateral, spinning, rolling, restitution, OBJECT_RANK, time, shape in FLAT),
        bounces_by_mass=bounces_by_mass,
        hull=hull,
    )
    return _add_net(object_model, keys) if "net" in keys else object_model


def _add_net(object_model: ObjectModel, keys: Mapping[str, Any]) -> ObjectModel:
    """Return the model with the net that the keys describe."""
    table = _subtable(keys, "net", ("members", "loop"))
    members = table.get("members")
    if not isinstance(members, int) or isinstance(members, bool) or not 2 <= members <= MAX_NET_MEMBERS:
        raise ConfigurationError(f"net.members = {members!r:.80} must be an integer from 2 to {MAX_NET_MEMBERS}")
    net = Net(members, _number(table, "loop", NET_LOOPS, "m", "net."))
    shortest = net.shortest_loop(object_model.flank_radius)
    if net.loop < shortest:
        raise ConfigurationError(
            f"net.loop = {net.loop:g} is too short for {members} objects side by side; "
            f"at least {shortest:.3f} m is needed"
        )
    return replace(object_model, net=net)


def _half_size(keys: Mapping[str, Any], shape: str) -> tuple[float, ...]:
    """Return the half sizes [m] of a shape other than a mesh, in MuJoCo's order."""
    half = (0.5 * WIDTHS[0], 0.5 * WIDTHS[1])
    if shape == "box":
        return tuple(0.5 * edge for edge in _lengths(keys, "edges", WIDTHS))
    if shape == "ellipsoid":
        return tuple(_lengths(keys, "radii", half))
    radius = _number(keys, "radius", half, "m")
    if shape == "sphere":
        return (radius,)
    length = _number(keys, "length", WIDTHS, "m")
    if shape == "cylinder":
        return radius, 0.5 * length
    if length <= 2.0 * radius:
        raise ConfigurationError(
            f"length = {length:g} must be more than twice the radius, because it is the length of the "
            "whole capsule; make a ball a sphere"
        )
    return radius, 0.5 * length - radius


def _load_mesh(keys: Mapping[str, Any], folder: Path) -> Hull | Solid:
    """Return the body of the mesh that the keys name."""
    as_hull = keys.get("hull", False)
    if not isinstance(as_hull, bool):
        raise ConfigurationError(f"hull = {as_hull!r:.80} must be true or false")
    file, unit = keys.get("file"), keys.get("unit")
    if not isinstance(file, str) or not file:
        raise ConfigurationError(f"file = {file!r:.80} must be the path of an STL or OBJ file")
    if not isinstance(unit, str) or unit not in UNITS:
        raise ConfigurationError(
            f"unit = {unit!r:.80} must be one of {', '.join(map(repr, UNITS))}; a mesh file does not state its unit"
        )
    scale = _number({"scale": 1.0, **keys}, "scale", (1e-4, 1e4), "")
    load = Hull.load if as_hull else load_solid
    body = load(folder / file, UNITS[unit] * scale)
    least, most = 2.0 * min(body.half_extents), 2.0 * max(body.half_extents)
    if not WIDTHS[0] <= least <= most <= WIDTHS[1]:
        raise ConfigurationError(
            f"the mesh measures {least:.3g} to {most:.3g} m across, and {WIDTHS[0]:g} to {WIDTHS[1]:g} m are allowed; "
            "check unit and scale"
        )
    return body


def _toml(value: Any) -> str:
    """Return a value as TOML."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    if isinstance(value, bool):
        return str(value).lower()
    return repr(float(value)) if isinstance(value, float) else str(value)


def _subtable(keys: Mapping[str, Any], key: str, valid: tuple[str, ...] | None) -> dict[str, Any]:
    """Return the table `key` of `keys`, or an empty one. Its keys must be among `valid`, unless that is None."""
    table = keys.get(key, {})
    if not isinstance(table, Mapping):
        raise ConfigurationError(f"{key} = {table!r:.80} must be a table")
    if valid is not None:
        _reject_unknown(table, valid, f"[{key}]")
    return dict(table)


def _reject_unknown(keys: Mapping[str, Any], valid: tuple[str, ...], owner: str) -> None:
    """Reject keys that are not valid; `owner` names the table or shape in the error."""
    for key in keys:
        if key not in valid:
            remedy = remedy_for(key, valid, f"valid keys are {', '.join(valid)}")
            raise ConfigurationError(f"{owner} has no key {key!r}; {remedy}")


def _number(keys: Mapping[str, Any], key: str, bounds: tuple[float, float], unit: str, prefix: str = "") -> float:
    """Return the number `key`, which must lie within `bounds`; `prefix` names the table of the key."""
    if key not in keys:
        raise ConfigurationError(f"the key {prefix + key!r} is missing")
    return _check_number(keys[key], prefix + key, bounds, unit)


def _lengths(keys: Mapping[str, Any], key: str, bounds: tuple[float, float]) -> list[float]:
    """Return the three lengths [m] of the list `key`, each within `bounds`."""
    values = keys.get(key)
    if not isinstance(values, list | tuple) or len(values) != 3:
        raise ConfigurationError(f"{key} = {values!r:.80} must be a list of 3 lengths in m")
    return [_check_number(value, f"{key}[{i}]", bounds, "m") for i, value in enumerate(values)]


def _check_number(value: Any, key: str, bounds: tuple[float, float], unit: str) -> float:
    low, high = bounds
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value) or not low <= value <= high:
        allowed = f"{low:g} to {high:g} {unit}".rstrip()
        raise ConfigurationError(f"{key} = {value!r:.80} must be a number from {allowed}")
    return float(value)
