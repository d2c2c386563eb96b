"""Code that decides a result calls nothing that rounds differently on another processor or under another Python."""

import ast
from pathlib import Path

import pytest

from pilegrasp_ctrl import provenance

PACKAGE = provenance.deciding_files()[0].parent

BLAS = {
    "dot",
    "vdot",
    "inner",
    "matmul",
    "vecdot",
    "matvec",
    "vecmat",
    "tensordot",
    "einsum_path",
    "convolve",
    "correlate",
}
BLAS |= {"cov", "corrcoef", "polyfit", "linalg"}
"""Names in numpy that call BLAS or LAPACK."""

ROUNDED_BY_PROCESSOR = {"exp", "exp2", "expm1", "log", "log2", "log10", "log1p", "logaddexp", "logaddexp2", "power"}
ROUNDED_BY_PROCESSOR |= {"float_power", "cbrt", "tan", "arcsin", "arccos", "arctan", "arctan2", "sinh", "cosh", "tanh"}
ROUNDED_BY_PROCESSOR |= {"arcsinh", "arccosh", "arctanh", "geomspace", "logspace", "sinc", "i0"}
"""Functions of numpy that have kernels of their own for AVX-512 or AVX2, which round differently."""

ALLOWED = {
    ("programs.order_program", "sum((pick.delivered for pick in self.attempts))"): "it adds whole numbers",
    ("recording", "sum(sizes.values())"): "it adds whole numbers",
    ("episode", "attempt.transform_known_to_scene @ pose"): "a product of poses",
    ("planning.layout", "self.transform_base_to_world @ known.transform_base_to_world.inverse()"): "a product of poses",
    ("sim.start_posture", "self._base.inverse() @ pose"): "a product of poses",
}
"""Modules and expressions that a rule forbids, and why they do no harm."""


def module_of(file: Path) -> str:
    return ".".join(file.relative_to(PACKAGE).with_suffix("").parts)


def is_numpy(node: ast.expr, name: str) -> bool:
    return isinstance(node, ast.Attribute) and ast.unparse(node) == f"np.{name}"


def is_whole(node: ast.expr) -> bool:
    """Return whether an expression counts: it is a comparison, a negation or a whole number."""
    whole = isinstance(node, ast.Constant) and isinstance(node.value, int)
    return whole or isinstance(node, ast.Compare) or (isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not))


def fault(node: ast.AST) -> str:
    """Return why a node may round differently elsewhere, or an empty text."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.MatMult):
        return "@ calls BLAS; use pilegrasp_ctrl.vectors or a kernel"
    if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.Pow):
        exponent = node.right if isinstance(node, ast.BinOp) else node.value
        if not (isinstance(exponent, ast.Constant) and exponent.value == 2):
            return "** of an array is numpy's power; use products, or math.pow for numbers"
    if isinstance(node, ast.Attribute):
        if isinstance(node.value, ast.Name) and node.value.id == "np":
            if node.attr in BLAS:
                return f"np.{node.attr} calls BLAS; use pilegrasp_ctrl.vectors or a kernel"
            if node.attr in ROUNDED_BY_PROCESSOR:
                return f"np.{node.attr} has kernels of its own for some processors; use math"
        elif node.attr == "dot":
            return ".dot calls BLAS; use pilegrasp_ctrl.vectors or a kernel"
    if isinstance(node, ast.ImportFrom) and node.module in (
        "numpy",
        "numpy.linalg",
        "math",
        "statistics",
        "scipy.linalg",
    ):
        names = {alias.name for alias in node.names} & (
            BLAS | ROUNDED_BY_PROCESSOR if node.module == "numpy" else {"sumprod"}
        )
        if names or node.module in ("numpy.linalg", "statistics", "scipy.linalg"):
            return f"{node.module} may not be imported from"
    if isinstance(node, ast.Import) and any(alias.name in ("statistics", "scipy.linalg") for alias in node.names):
        return "statistics and scipy.linalg round differently elsewhere"
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "sum":
        added = node.args[0]
        if not (isinstance(added, ast.GeneratorExp | ast.ListComp) and is_whole(added.elt)):
            return "the builtin sum of floats is compensated since Python 3.12; use vectors.in_order"
    if isinstance(node, ast.For | ast.comprehension) and is_set(node.iter):
        return "the order of a set of texts differs from run to run; sort it"
    return ""


def is_set(node: ast.expr) -> bool:
    called = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("set", "frozenset")
    return called or isinstance(node, ast.Set | ast.SetComp)


def faults(module: str, source: str) -> list[str]:
    """Return the faults of a module, one line each."""
    tree, found = ast.parse(source), []
    # The length along an axis is a sum of squares; without an axis it calls BLAS.
    lengths = {
        id(inside)
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and is_numpy(node.func, "linalg.norm")
        if any(keyword.arg == "axis" for keyword in node.keywords)
        for inside in ast.walk(node.func)
    }
    for node in ast.walk(tree):
        if id(node) not in lengths and (why := fault(node)):
            text = ast.unparse(node)
            if (module, text) not in ALLOWED:
                found.append(f"{module}:{getattr(node, 'lineno', '')} {text}: {why}")
    return found


def deciding_modules() -> dict[str, Path]:
    return {module_of(file): file for file in provenance.deciding_files()}


@pytest.mark.parametrize("module", sorted(deciding_modules()))
def test_nothing_that_decides_a_result_rounds_differently_elsewhere(module):
    assert faults(module, deciding_modules()[module].read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    "source",
    [
        "a @ b", "a @= b", "a.dot(b)", "np.dot(a, b)", "np.linalg.inv(a)", "np.linalg.norm(a)", "np.matmul(a, b)",
        "from numpy.linalg import inv", "from numpy import dot", "import statistics", "from math import sumprod",
        "np.exp(a)", "np.arctan2(a, b)", "np.log(a)", "a ** b", "a ** 0.5", "a **= 3", "np.tanh(a)",
        "sum(a)", "sum(x * x for x in a)", "[f(x) for x in set(a)]", "for x in {1, 2}: pass",
    ],
)  # fmt: skip
def test_what_rounds_differently_elsewhere_is_found(source):
    assert faults("sim.scene", source)


@pytest.mark.parametrize(
    "source",
    [
        "np.linalg.norm(a, axis=1)", "a ** 2", "math.exp(a)", "sum(x > 0 for x in a)", "sum(1 for x in a)",
        "np.sqrt(a)",
        "a.sum(axis=0)", "np.hypot(a, b)", "vectors.inner(a, b)", "for x in sorted(set(a)): pass", "np.cross(a, b)",
    ],
)  # fmt: skip
def test_what_rounds_equally_everywhere_is_allowed(source):
    assert faults("sim.scene", source) == []


def test_every_exception_is_still_there():
    texts = {
        (name, ast.unparse(node))
        for name, file in deciding_modules().items()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.expr)
    }
    assert ALLOWED.keys() <= texts
