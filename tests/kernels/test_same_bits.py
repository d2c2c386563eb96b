"""The law gives the same bits compiled and as plain Python, and keeps the rules that this rests on."""

import ast
import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

import pilegrasp_ctrl as pg
from arms import ARMS, HAND, HOME, nearby, quiet_states, random_states, with_friction
from places import ROOT

KERNELS = sorted((ROOT / "pilegrasp_ctrl" / "kernels").glob("*.py"))


def controllers(arm):
    q = HOME[arm.name]
    springs = [300.0, 500.0, 200.0, 20.0, 30.0, 10.0]
    axis = pg.AxisTask(arm, [0.0, 0.0, 1.0], [0.3, 0.0, -1.0])
    coupling = pg.CouplingTask(arm, dict.fromkeys(arm.joint_names[:2], 1.0))
    yield pg.OperationalSpaceController(arm, posture=q, tasks=[axis, coupling])
    yield pg.OperationalSpaceController(arm, posture=q, mask=[1, 1, 1, 1, 0, 1])
    yield pg.ImpedanceController(arm, pg.Impedance(springs, frame="tool"), q)
    yield pg.ImpedanceController(arm, pg.Impedance(springs, inertia=8.0, dead_band=[0.5, 0.1]), friction=False)
    yield pg.InverseDynamics(arm, [pg.JointTask(arm, q, pg.JointImpedance(np.geomspace(60.0, 2.0, arm.nv)))])


def torques_digest():
    """A digest of the torques of several controllers at quiet, random and fast states."""
    digest = hashlib.sha256()
    for name in ARMS:
        arm = with_friction(name, HAND)
        for controller in controllers(arm):
            for q, v in (*quiet_states(arm, 3), *random_states(arm, 12), *random_states(arm, 5, seed=1, speed=1.0)):
                observation = pg.Observation(0.0, q, v, np.linspace(-2.0, 3.0, 6))
                reference = () if type(controller) is pg.InverseDynamics else (nearby(arm.update(q, v), turn=0.4),)
                output = controller.step(observation, *reference)
                controller.reset()
                digest.update(output.command.torque.tobytes())
                digest.update("".join(output.active_limits).encode())
    return digest.hexdigest()


def test_compiled_and_plain_kernels_give_the_same_torques_to_the_bit():
    paths = os.pathsep.join([str(ROOT), str(ROOT / "tests" / "helpers"), str(ROOT / "docs" / "studies")])
    plain = subprocess.run(
        [sys.executable, "-c", "from test_same_bits import torques_digest; print(torques_digest())"],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": f"{paths}{os.pathsep}{os.path.dirname(__file__)}"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert plain.stdout.split()[-1] == torques_digest()


FORBIDDEN_ATTRIBUTES = {"dot", "sum", "linalg", "matmul", "einsum", "exp", "log", "power", "tanh", "arctan2"}


def faults(source):
    """The places of a kernel module that break the rules of `kernels/compile.py`."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult | ast.Pow):
            found.append(f"line {node.lineno}: {type(node.op).__name__}")
        if isinstance(node, ast.Attribute) and node.attr in FORBIDDEN_ATTRIBUTES:
            found.append(f"line {node.lineno}: .{node.attr}")
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in {"sum", "pow"}:
            found.append(f"line {node.lineno}: {node.func.id}")
    return found


@pytest.mark.parametrize("file", KERNELS, ids=lambda file: file.stem)
def test_kernels_keep_the_rules_that_make_bits_equal(file):
    assert faults(file.read_text(encoding="utf-8")) == []


def test_a_kernel_that_breaks_a_rule_is_found():
    for broken in ("y = A @ x", "y = x**2", "y = np.dot(A, x)", "y = x.sum()", "y = np.linalg.norm(x)", "y = sum(x)"):
        assert faults(broken)
