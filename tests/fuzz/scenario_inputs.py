"""Scenarios, objects and gains as inputs: tables with some keys changed, cut, or of another type."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Callable, Mapping
from typing import Any

from hypothesis import strategies as st

from pilegrasp_ctrl.config import Scenario, dotted_keys
from pilegrasp_ctrl.robots import path as robot_path
from pilegrasp_ctrl.scenarios import FOLDER, object_files
from question import SPECIAL, Question
from values import FUNCTIONS, MINE, PATHS, damaged, noise, numbers, texts, toml, toml_table, values

SCENARIOS = {path.stem: tomllib.loads(path.read_text()) for path in sorted(FOLDER.glob("*.toml"))}
"""The shipped scenarios."""

SHORT_LINE = {"program": "line", "line": {"displacement": [0.0, 0.01, 0.0]}}
"""A scenario whose attempt takes a moment."""

OBJECTS = {name: tomllib.loads(path.read_text()) for name, path in object_files().items()}
"""The shipped objects."""

MESHES = (
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n",
    "v 0 0 0\nv 0.05 0 0\nv 0 0.05 0\nv 0 0 0.05\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n",
)
"""A text STL, which is not allowed, and an OBJ, which is."""

_SCHEMA = Scenario.model_json_schema()


def documented(key: str) -> st.SearchStrategy[Any]:
    """Values of a key of a scenario inside its documented range, the ends first."""
    return _of_schema(_part(key))


def _part(key: str) -> dict[str, Any]:
    part = _SCHEMA
    for name in key.split("."):
        part = part["properties"][name]
        if "$ref" in part:
            part = _SCHEMA["$defs"][part["$ref"].rpartition("/")[2]]
    return part


def _of_schema(part: Mapping[str, Any]) -> st.SearchStrategy[Any]:
    if "anyOf" in part:
        return st.one_of(*(_of_schema(option) for option in part["anyOf"] if option.get("type") != "null"))
    if "enum" in part or "const" in part:
        return st.sampled_from(part.get("enum") or [part["const"]])
    match part["type"]:
        case "boolean":
            return st.booleans()
        case "array" if "prefixItems" in part:
            return st.tuples(*map(_of_schema, part["prefixItems"])).map(list)
        case "number" | "integer":
            low, high = part.get("minimum", part.get("exclusiveMinimum")), part["maximum"]
            if part["type"] == "integer":
                return st.one_of(st.sampled_from((low, high)), st.integers(low, high))
            ends = [high] if "exclusiveMinimum" in part else [low, high]
            inside = st.floats(low, high, exclude_min="exclusiveMinimum" in part, allow_subnormal=False)
            return st.one_of(st.sampled_from(ends), inside)
    return st.sampled_from(("light_sphere", "cube", "lime"))


@st.composite
def scenario_tables(draw: Callable[..., Any]) -> dict[str, Any]:
    """A shipped scenario, or a short line, with some keys changed."""
    table: dict[str, Any] = copy.deepcopy(draw(st.sampled_from((SHORT_LINE, *SCENARIOS.values()))))
    if table.get("program") != "line":
        table.setdefault("pile", {})["count"] = draw(st.sampled_from((1, 2, 3)))
    for _ in range(draw(st.integers(1, 4))):
        match draw(
            st.sampled_from(("documented", "documented", "group", "any", "unknown", "cut", "table", "function"))
        ):
            case "function":
                table["program"] = draw(st.sampled_from(FUNCTIONS))
            case "group":
                for key, value in draw(st.sampled_from(sorted(_GROUPS)).flatmap(grouped)).items():
                    _put(table, key, value)
            case "documented":
                key = draw(st.sampled_from(_NUMERIC))
                _put(table, key, draw(documented(key)))
            case "any":
                _put(table, draw(st.sampled_from(dotted_keys())), draw(values()))
            case "unknown":
                _put(table, draw(texts(12)).replace(".", "-") or "a", draw(values()))
            case "cut" if table:
                table.pop(draw(st.sampled_from(sorted(table))))
            case "table":
                _put(table, draw(st.sampled_from(_TABLES)), draw(values()))
    return table


_NUMERIC = [
    key
    for key in dotted_keys()
    if key
    not in ("name", "summary", "tags", "robot", "pile.object", "controller.gains", "controller.solver", "pile.count")
]


_TABLES = sorted({key.rpartition(".")[0] for key in _NUMERIC} - {""})
"""Tables of a scenario, with dots."""

_BIN = [key for key in _NUMERIC if key.startswith("support.bin_")] + ["pile.frame_position"]
_GROUPS = {
    "bin": (_BIN, {"support.bin": True}),
    "order": ([*_BIN, *(key for key in _NUMERIC if key.startswith("order."))], {"program": "order"}),
    "known": ([key for key in _NUMERIC if key.startswith("known.")], {}),
    "spread": ([key for key in _NUMERIC if key.startswith("pile.spread.")], {}),
    "hand model": ([key for key in _NUMERIC if key.startswith("hand_model.")], {}),
}
"""Keys that belong together, and what gives them an effect."""


def grouped(name: str) -> st.SearchStrategy[dict[str, Any]]:
    """Documented values of some keys of a group, which have an effect together."""
    keys, besides = _GROUPS[name]
    chosen = st.lists(st.sampled_from(keys), min_size=1, max_size=4, unique=True)
    tables = chosen.flatmap(lambda found: st.fixed_dictionaries({key: documented(key) for key in found}))
    return tables.map(lambda table: besides | table)


def _put(table: dict[str, Any], key: str, value: Any) -> None:
    *places, leaf = key.split(".")
    for place in places:
        inner = table.setdefault(place, {})
        if not isinstance(inner, dict):
            return
        table = inner
    table[leaf] = value


def files(
    tables: st.SearchStrategy[Mapping[str, Any]], shipped: Mapping[str, Mapping[str, Any]]
) -> st.SearchStrategy[Any]:
    """Contents of a TOML file: of a table, damaged, of noise, or no file at all."""
    texts_of = st.sampled_from([toml_table(table).encode() for table in shipped.values()])
    return st.one_of(
        tables.map(lambda table: toml_table(table).encode()),
        tables.map(lambda table: toml_table(table).encode()),
        texts_of.flatmap(damaged),
        noise(),
        st.sampled_from(SPECIAL),
    )


@st.composite
def scenario_files(draw: Callable[..., Any]) -> Question:
    """A file of a scenario, to run, and perhaps a folder of modules."""
    content = draw(files(scenario_tables(), SCENARIOS))
    plugins = ("--plugins", ".") if draw(st.booleans()) else ()
    return Question("scenario file", ("run", "a.toml", "--json", *plugins), {"a.toml": content, "mine.py": MINE})


@st.composite
def corners(draw: Callable[..., Any]) -> Question:
    """A whole attempt whose keys lie inside their documented ranges, many of them at an end."""
    table: dict[str, Any] = copy.deepcopy(draw(st.sampled_from((SHORT_LINE, *SCENARIOS.values()))))
    for key in draw(st.lists(st.sampled_from(_NUMERIC), min_size=2, max_size=8, unique=True)):
        if key not in ("program", "hand", "controller.rate", "sim.timestep"):
            _put(table, key, draw(documented(key)))
    if table.get("program") != "line":
        _put(table, "pile.count", draw(st.sampled_from((1, 2, 5, 12))))
        _put(table, "pile.object", draw(st.sampled_from(sorted(OBJECTS))))
    if draw(st.booleans()):
        _put(table, "controller.solver", draw(st.sampled_from(("daqp", "osqp", "quadprog"))))
    call = ("@attempt", "a.toml", str(draw(st.integers(0, 9999))))
    return Question("corner", call, {"a.toml": toml_table(table).encode()}, stop_after=None, patience=600.0)


@st.composite
def object_tables(draw: Callable[..., Any]) -> dict[str, Any]:
    """A shipped object, or one of another shape, with some keys changed."""
    sizes = st.one_of(st.floats(0.002, 0.5), numbers())
    made = {
        "box": {"shape": "box", "mass": 0.1, "edges": [0.04, 0.05, 0.06]},
        "capsule": {"shape": "capsule", "mass": 0.1, "radius": 0.02, "length": 0.08},
        "ellipsoid": {"shape": "ellipsoid", "mass": 0.1, "radii": [0.02, 0.03, 0.04]},
        "mesh": {"shape": "mesh", "mass": 0.1, "file": "a.obj", "unit": "m"},
    }
    table: dict[str, Any] = copy.deepcopy(draw(st.sampled_from((*made.values(), *OBJECTS.values()))))
    keys = (
        "shape",
        "mass",
        "radius",
        "length",
        "edges",
        "radii",
        "inertia_factor",
        "friction",
        "restitution",
        "net",
        "file",
        "hull",
    )
    for _ in range(draw(st.integers(0, 3))):
        key = draw(st.sampled_from(keys))
        match draw(st.sampled_from(("size", "any", "cut", "net", "lengths"))):
            case "size":
                table[key] = draw(sizes)
            case "any":
                table[draw(st.one_of(st.just(key), texts(8)))] = draw(values())
            case "cut":
                table.pop(key, None)
            case "net":
                table["net"] = {"members": draw(st.integers(0, 14)), "loop": draw(sizes)}
            case "lengths":
                table[key] = draw(st.lists(sizes, min_size=2, max_size=4))
    return table


@st.composite
def object_inputs(draw: Callable[..., Any]) -> Question:
    """A file of an object and perhaps a mesh, to run a grasp of one."""
    meshes = st.one_of(
        st.sampled_from([text.encode() for text in MESHES]),
        st.sampled_from([text.encode() for text in MESHES]).flatmap(damaged),
        noise(),
        st.sampled_from(SPECIAL),
    )
    content = {"a.toml": draw(files(object_tables(), OBJECTS)), "a.obj": draw(meshes), "a.stl": draw(meshes)}
    if draw(st.booleans()):
        content["a.obj.pieces.obj"] = draw(meshes)
    settings = ["--set", "pile.object=./a.toml", "--set", f"pile.count={draw(st.integers(1, 3))}"]
    if draw(st.booleans()):
        settings += ["--set", f"pile.scale={draw(st.sampled_from((0.25, 4.0)))}"]
    return Question("object file", ("run", "spheres_wall", *settings), content)


@st.composite
def gains_tables(draw: Callable[..., Any]) -> dict[str, Any]:
    """Shipped gains with some keys changed."""
    table: dict[str, Any] = copy.deepcopy(draw(st.sampled_from(tuple(_GAINS.values()))))
    name = next(iter(table))
    keys = ("stiffness", "damping_ratio", "damping", "inertia", "desired_force", "dead_band", "frame", "force_gain")
    usual = st.one_of(st.floats(0.0, 3000.0), st.lists(st.floats(0.0, 3000.0), min_size=6, max_size=6))
    for key in draw(st.lists(st.sampled_from(keys[: 2 if name == "motion" else 8]), max_size=2)):
        table[name][key] = draw(st.one_of(usual, usual, values()))
    match draw(st.integers(0, 9)):
        case 0:
            table[draw(texts(8))] = draw(values())
        case 1:
            table[name][draw(texts(8))] = draw(values())
    if draw(st.integers(0, 19)) == 0:
        table[draw(texts(8))] = draw(values())
    return table


_GAINS = {
    name: tomllib.loads(robot_path("wam7", f"{name}.toml").read_text()) for name in ("operational_space", "impedance")
}


@st.composite
def gains_files(draw: Callable[..., Any]) -> Question:
    """A file of gains, to run a line with, or to begin a search with."""
    content = {"a.toml": draw(files(gains_tables(), _GAINS))}
    motion = isinstance(content, bytes) and b"motion" in content
    kind = ("impedance", "operational_space")[motion != (draw(st.integers(0, 4)) == 0)]
    setting = ("--set", f"controller.kind={kind}")
    if draw(st.booleans()):
        return Question("gains file", ("run", "free_space_line", *setting, "--set", "controller.gains=a.toml"), content)
    call = ("tune", "free_space_line", "--controller", kind, "--start", "a.toml", "--trials", "1", "--out", "search")
    return Question("gains file", call, content, writes=("search",))


def settings() -> st.SearchStrategy[list[str]]:
    """Texts behind --set."""
    groups = st.sampled_from(sorted(_GROUPS)).flatmap(grouped)
    together = groups.map(lambda table: [f"{key}={toml(value)}" for key, value in table.items()])
    pairs = st.sampled_from(_NUMERIC).flatmap(lambda key: st.tuples(st.just(key), documented(key)))
    usual = pairs.map(lambda pair: f"{pair[0]}={toml(pair[1])}")
    odd = st.builds("{}={}".format, st.one_of(st.sampled_from(dotted_keys()), texts(8)), values().map(toml))
    raw = st.one_of(
        texts(), st.sampled_from(PATHS), st.just("pile.count=1\npile.mass=2"), st.just("pile.count=" + "9" * 6000)
    )
    alone = st.lists(st.one_of(usual, usual, odd, raw), max_size=2)
    return st.one_of(alone, alone, alone, together)
