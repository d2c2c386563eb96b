"""Rules of imports: control does not import the simulator, analysis needs a recording alone, and imports are cheap."""

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import pilegrasp_ctrl
import places
from pilegrasp_ctrl.provenance import ROOMS

ROOT = places.ROOT / "pilegrasp_ctrl"

SOLVERS = {"qpsolvers", "osqp", "daqp", "proxsuite", "quadprog", "numba"}
ENGINES = {"pinocchio", "mujoco", "mink", "meshcat", "optuna", "matplotlib", "seaborn"} | SOLVERS
CONTROL = {"pinocchio"} | SOLVERS

RANK = {room: rank for rank, row in enumerate(ROOMS) for room in row}

ENGINES_OF = dict.fromkeys((room for row in ROOMS for room in row), frozenset())
"""Engines that a room may import."""
for some, engines in (
    ("kernels", {"numba"}),
    ("arm tasks limits qp control plant trajectories primitives", CONTROL),
    ("sim", {"mujoco", "mink"}),
    ("viewer", {"meshcat"}),
    ("study tuning search validation learning cli scripts __init__ __main__", ENGINES),
):
    ENGINES_OF.update(dict.fromkeys(some.split(), engines))

ON_CALL = {name: {"mujoco"} for name in ("arm.mjcf", "arm.mjcf_couplings", "arm.collision_balls")} | {
    "viewer.plot": {"matplotlib"},
    "recording": {"viewer"},
}
"""Engines and rooms that a module may import inside its functions, against the rule of its room: `ArmModel.from_mjcf`
and `capsules_of` do, and a recording that shows itself in a notebook."""

ONLY = {
    "recording": {"recording_parts"},
    "recording_parts": set(),
    "analysis": {"recording", "recording_parts"},
    "sim": {"kernels", "planning", "recording", "recording_parts", "analysis"},
    "viewer": {"recording", "recording_parts", "analysis"},
}
"""Rooms that, besides the base, may import from these rooms alone: a recording is read without an engine, and the
simulator does not import control."""


@cache
def modules() -> dict[str, Path]:
    """Return every module of the package, linked folders included, by its dotted name below the package."""
    found = {}
    for folder in (ROOT, *(path for path in ROOT.iterdir() if path.is_dir())):
        for path in sorted(folder.rglob("*.py")):
            parts = list(path.relative_to(ROOT).with_suffix("").parts)
            found[".".join(parts)] = path
    return found


def room(module: str) -> str:
    """Return the room of a module. In scenarios/, the scripts are on top; the finder is in the base."""
    top, _, rest = module.partition(".")
    return "scripts" if top == "scenarios" and rest not in ("", "__init__") else top


def imports(module: str, source: str, inside_functions: bool = True) -> set[str]:
    """Return the absolute dotted names of all imports of a module, also inside functions unless told otherwise."""
    package = ["pilegrasp_ctrl", *module.split(".")[:-1]]
    names = set()
    tree = ast.parse(source)
    inner = {id(node) for outer in ast.walk(tree) if isinstance(outer, ast.FunctionDef) for node in ast.walk(outer)}
    for node in ast.walk(tree):
        if id(node) in inner and not inside_functions:
            continue
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            stem = ".".join([*base, *([node.module] if node.module else [])])
            names.update({f"{stem}.{alias.name}" for alias in node.names} if stem == "pilegrasp_ctrl" else {stem})
    return names


def may_import(own: str, other: str) -> bool:
    """Return whether a module of one room may import from another room."""
    if own == other or other in ROOMS[0]:
        return own not in ROOMS[0] or RANK[other] <= RANK[own]
    return other in ONLY[own] if own in ONLY else RANK[other] <= RANK[own]


def violations(module: str, source: str) -> list[str]:
    own = room(module)
    wrong = []
    at_once = imports(module, source, inside_functions=False)
    on_call = ON_CALL.get(module, set())
    for name in sorted(imports(module, source)):
        top, _, inside = name.partition(".")
        if top in ("robots", "scenarios", "viewer"):
            wrong.append(f"{module} imports {name}: say pilegrasp_ctrl.{name}")
        elif top in ENGINES and top not in ENGINES_OF[own] and (top not in on_call or name in at_once):
            wrong.append(f"{module} ({own}) imports {name}")
        elif top == "pilegrasp_ctrl" and inside != "__version__":
            other = room(inside) if inside else "__init__"
            if not may_import(own, other) and (other not in on_call or name in at_once):
                wrong.append(f"{module} ({own}) imports {name} ({other})")
    return wrong


def test_every_module_has_a_room_and_every_room_a_module():
    found = modules()
    assert {"types", "robots.__init__", "scenarios.__init__", "cli.__init__"} <= found.keys()
    assert {room(module) for module in found} == RANK.keys()


def test_no_rooms_import_one_another_in_a_circle():
    sources = {module: path.read_text(encoding="utf-8") for module, path in modules().items()}
    arrows: dict[str, set[str]] = {}
    for module, source in sources.items():
        names = {name.partition(".")[2] for name in imports(module, source) if name.startswith("pilegrasp_ctrl.")}
        names = {name for name in names if room(name) not in ON_CALL.get(module, ())}
        arrows.setdefault(room(module), set()).update({room(name) for name in names if name} - {room(module)})
    arrows = {own: {other for other in others if other in arrows} for own, others in arrows.items()}
    while free := {own for own, others in arrows.items() if not others & arrows.keys()}:
        arrows = {own: others for own, others in arrows.items() if own not in free}
    assert arrows == {}


@pytest.mark.parametrize("module", sorted(modules()))
def test_imports_point_down(module):
    assert violations(module, modules()[module].read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("qp.program", "import mujoco"),
        ("qp.program", "def f():\n    from mujoco import mjx"),
        ("arm.mjcf", "import mujoco"),
        ("arm.mjcf", "def f():\n    import mink"),
        ("arm.model", "def f():\n    import mujoco"),
        ("qp.program", "from ..sim.scene import build"),
        ("qp.program", "from ..episode import run"),
        ("sim.scene", "import pinocchio as pin"),
        ("sim.scene", "from ..tasks.gains import MotionGains"),
        ("sim.scene", "from pilegrasp_ctrl.tasks.gains import MotionGains"),
        ("sim.scene", "from ..arm import model"),
        ("viewer.page.document", "from pilegrasp_ctrl.sim.scene import build"),
        ("viewer.page.document", "import robots"),
        ("recording", "import mujoco"),
        ("config", "from .cli import main"),
        ("episode", "from .validation.installation import examine"),
        ("episode", "from .viewer import write_html"),
        ("sim.scene", "import pilegrasp_ctrl"),
        ("scenarios.__init__", "import pinocchio"),
        ("cli", "from scenarios import find"),
        ("types", "from .config import Scenario\nimport meshcat.geometry"),
    ],
)
def test_an_import_that_points_up_is_found(module, source):
    assert violations(module, source)


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("qp.program", "import daqp\nfrom ..types import Pose\nfrom ..tasks.gains import MotionGains\nimport numpy"),
        ("arm.mjcf", "def f():\n    import mujoco"),
        ("sim.scene", "from ..robots import path\nfrom .objects import object_model"),
        ("episode", "from .tasks.gains import MotionGains\nfrom .sim.scene import Scene"),
        ("scenarios.grasp_wall", "import pilegrasp_ctrl as pg\nfrom pilegrasp_ctrl.viewer import write_html"),
    ],
)
def test_an_import_that_points_down_is_allowed(module, source):
    assert violations(module, source) == []


@pytest.mark.parametrize("module", ["episode", "recorder"])
def test_the_loop_knows_the_simulator_by_the_backend_protocol_alone(module):
    source = modules()[module].read_text(encoding="utf-8")
    assert {name for name in imports(module, source) if ".sim" in name} == {"pilegrasp_ctrl.sim.backend"}
    read = {node.attr for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Attribute)}
    assert not read & {"data", "scene", "model"}


def foreign_private_names(source: str) -> set[str]:
    """Return the private names of other modules that a module imports or reads."""
    tree = ast.parse(source)
    stored = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)]
    own = {node.attr for node in stored if ast.unparse(node.value) in ("self", "cls")}
    own |= {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    own |= {
        node.target.id
        for node in ast.walk(tree)
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
    }
    read = {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name | ast.Attribute)
        and ast.unparse(node.value) not in ("self", "cls")
    }
    brought = {alias.name for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names}
    # optuna has no other way to a trial that was begun in a process that is gone.
    public_by_convention = {"_replace", "_asdict", "_fields", "_exit", "_trial_id"}
    private = {name for name in read - own | brought if name.startswith("_") and not name.startswith("__")}
    return private - public_by_convention


@pytest.mark.parametrize("module", sorted(modules()))
def test_no_private_name_of_another_module_is_used(module):
    assert foreign_private_names(modules()[module].read_text(encoding="utf-8")) == set()


@pytest.mark.parametrize(
    "source",
    ["from .episode import _Loop", "simulation._stepper = 1\nprint(arm._frame)", "patch(episode, module._solve)"],
)
def test_a_private_name_of_another_module_is_found(source):
    assert foreign_private_names(source)


def loaded_after(statement: str) -> set[str]:
    """Return the top-level modules that a new interpreter has loaded after a statement."""
    code = f"import sys; {statement}; print(*sorted({{name.partition('.')[0] for name in sys.modules}}))"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT.parent)
    return set(answer.stdout.split())


@pytest.mark.parametrize(
    ("statement", "absent"),
    [
        ("import pilegrasp_ctrl; dir(pilegrasp_ctrl); pilegrasp_ctrl.load_scenario('spheres_wall')", ENGINES),
        ("import pilegrasp_ctrl.cli", ENGINES),
        ("import pilegrasp_ctrl.recording", ENGINES),
        ("import pilegrasp_ctrl.robots", ENGINES),
        ("import pilegrasp_ctrl.viewer", ENGINES - {"meshcat"}),
        (
            "from pilegrasp_ctrl import ArmModel, OperationalSpaceController, StraightLine",
            {"mujoco", "mink", "meshcat"},
        ),
        ("import pilegrasp_ctrl.sim.scene", {"pinocchio", "meshcat"}),
    ],
)
def test_importing_loads_no_engine_that_is_not_needed(statement, absent):
    assert not loaded_after(statement) & absent


def test_every_public_name_resolves():
    for name in dir(pilegrasp_ctrl):
        assert getattr(pilegrasp_ctrl, name) is not None


def test_type_checkers_see_the_names_that_resolve():
    tree = ast.parse((ROOT / "__init__.py").read_text(encoding="utf-8"))
    guarded = next(node for node in tree.body if isinstance(node, ast.If))
    declared = {
        alias.asname: node.module
        for node in ast.walk(guarded)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert declared == pilegrasp_ctrl._MODULES


def test_an_unknown_public_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="has no attribute 'Gripper'"):
        pilegrasp_ctrl.Gripper  # noqa: B018


def test_no_file_is_too_long():
    lengths = {module: len(path.read_text(encoding="utf-8").splitlines()) for module, path in modules().items()}
    assert {module: lines for module, lines in lengths.items() if lines > 350} == {}


@pytest.mark.parametrize("path", sorted((ROOT / "scenarios").glob("[!_]*.py")), ids=lambda path: path.name)
def test_a_script_is_short(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) < 40
