"""Who may import whom: control never sees the simulator, a recording is enough to draw, and importing is cheap."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import pilegrasp_ctrl

ROOT = Path(__file__).parents[1] / "pilegrasp_ctrl"

SOLVERS = {"qpsolvers", "osqp", "daqp", "proxsuite", "quadprog", "numba"}
ENGINES = {"pinocchio", "mujoco", "mink", "meshcat", "optuna", "matplotlib", "seaborn"} | SOLVERS

# layer: (its modules, the layers it may import beside its own, the engines it may import)
LAYERS = {
    "base": ({"types", "exceptions", "config", "config_sections", "output_file", "scenarios"}, set(), set()),
    "robots": ({"robots"}, {"base"}, set()),
    "control": (
        {"arm_model", "arm_state", "tasks", "limits", "control", "trajectories", "primitives"},
        {"base", "robots"},
        {"pinocchio"} | SOLVERS,
    ),
    "sim": ({"sim"}, {"base", "robots", "recording"}, {"mujoco", "mink"}),
    "recording": ({"recording", "contacts"}, {"base"}, set()),
    "viewer": ({"viewer"}, {"base", "recording"}, {"meshcat"}),
    "episode": (
        {"aim", "episode", "order", "preparation", "recorder"},
        {"base", "robots", "control", "sim", "recording"},
        {"pinocchio", "mujoco"},
    ),
    "top": (
        {"__init__", "cli", "doctor", "experiments", "scripts"},
        {"base", "robots", "control", "sim", "recording", "viewer", "episode"},
        ENGINES,
    ),
}
LAYER_OF = {module: layer for layer, (modules, _, _) in LAYERS.items() for module in modules}


def modules() -> dict[str, Path]:
    """Every module of the package by its dotted name below the package, the linked folders included."""
    found = {}
    for folder in (ROOT, *(path for path in ROOT.iterdir() if path.is_dir())):
        for path in sorted(folder.rglob("*.py")):
            parts = list(path.relative_to(ROOT).with_suffix("").parts)
            found[".".join(parts)] = path
    return found


def layer(module: str) -> str:
    """The scripts in scenarios/ are on top; the folder itself is data that anyone may find."""
    top, _, rest = module.partition(".")
    return LAYER_OF["scripts" if top == "scenarios" and rest not in ("", "__init__") else top]


def imports(module: str, source: str) -> set[str]:
    """Absolute dotted names of everything a module imports, wherever the statement stands."""
    package = ["pilegrasp_ctrl", *module.split(".")[:-1]]
    names = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            stem = ".".join([*base, *([node.module] if node.module else [])])
            names.update({f"{stem}.{alias.name}" for alias in node.names} if stem == "pilegrasp_ctrl" else {stem})
    return names


def violations(module: str, source: str) -> list[str]:
    own = layer(module)
    _, may_import, engines = LAYERS[own]
    wrong = []
    for name in sorted(imports(module, source)):
        top, _, inside = name.partition(".")
        if top in ("robots", "scenarios", "viewer"):
            wrong.append(f"{module} imports {name}: say pilegrasp_ctrl.{name}")
        elif top in ENGINES and top not in engines:
            wrong.append(f"{module} ({own}) imports {name}")
        elif top == "pilegrasp_ctrl" and inside != "__version__":
            other = layer(inside) if inside else "top"
            if other not in {own, *may_import}:
                wrong.append(f"{module} ({own}) imports {name} ({other})")
    return wrong


def test_every_module_is_found_and_has_a_layer():
    found = modules()
    assert {"types", "robots.__init__", "scenarios.__init__", "cli.__init__"} <= found.keys()
    assert all(layer(module) for module in found)


@pytest.mark.parametrize("module", sorted(modules()))
def test_imports_point_down(module):
    assert violations(module, modules()[module].read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("control.qp", "import mujoco"),
        ("control.qp", "def f():\n    from mujoco import mjx"),
        ("control.qp", "from ..sim.scene import build"),
        ("control.qp", "from ..episode import run"),
        ("sim.scene", "import pinocchio as pin"),
        ("sim.scene", "from ..control.gains import MotionGains"),
        ("sim.scene", "from pilegrasp_ctrl.control.gains import MotionGains"),
        ("sim.scene", "from .. import arm_model"),
        ("viewer.html", "from pilegrasp_ctrl.sim.scene import build"),
        ("viewer.html", "import robots"),
        ("recording", "import mujoco"),
        ("config", "from .cli import main"),
        ("episode", "from .doctor import examine"),
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
        ("control.qp", "import daqp\nfrom ..types import Pose\nfrom .gains import MotionGains\nimport numpy"),
        ("sim.scene", "from ..robots import path\nfrom .objects import object_kind"),
        ("episode", "from .control.gains import MotionGains\nfrom .sim.scene import Scene"),
        ("scenarios.grasp_wall", "import pilegrasp_ctrl as pg\nfrom pilegrasp_ctrl.viewer import write_html"),
    ],
)
def test_an_import_that_points_down_is_allowed(module, source):
    assert violations(module, source) == []


def loaded_after(statement: str) -> set[str]:
    """Top-level modules that a fresh interpreter holds after a statement."""
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


def test_no_file_has_grown_out_of_hand():
    lengths = {module: len(path.read_text(encoding="utf-8").splitlines()) for module, path in modules().items()}
    assert {module: lines for module, lines in lengths.items() if lines > 350} == {}


@pytest.mark.parametrize("path", sorted((ROOT / "scenarios").glob("[!_]*.py")), ids=lambda path: path.name)
def test_a_script_is_short(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) < 40
