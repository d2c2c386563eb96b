"""Count files, lines, undocumented constants and repeated facts of a checkout.

Usage: python docs/studies/tree_figures.py [FOLDER], the checkout of this file by default
"""

from __future__ import annotations

import ast
import re
from pathlib import Path
from statistics import median

from script import run_script

ROOT = Path(__file__).resolve().parents[2]
"""Folder of this checkout."""

FOLDERS = ("pilegrasp_ctrl", "robots", "scenarios", "viewer")
"""Folders of the product, without tests and documentation."""

FRAGMENT = re.compile(r"^\s+\w+: (of|from|that|whose|where|which|what|how|to|in|for|see) ", re.M)
"""Pattern of an argument or attribute whose description begins without a noun."""

FACTS = {
    "joint friction law (tanh), without compiled_*": r"(?:np|math)\.tanh\(",
    "versions of packages": r"importlib\.metadata|import_metadata",
    "Wilson interval": r"proportion_ci\(|1\.9599|Z \* Z|Z\*\*2",
    "Markdown table": r"\|---|def markdown_table",
    "process pool": r"ProcessPoolExecutor\(",
    "reader of TOML files": r"tomllib\.loads\([^f]*read_|tomllib\.loads\([^f]*decode|tomllib\.load\(",
    "whole-file write": r"os\.replace\(|\.replace\(path\)",
    "quaternion to matrix": r"1(?:\.0)? - 2(?:\.0)? \* \(y \* y",
    "finder of a browser": r"shutil\.which, |shutil\.which\(name\)",
    "finder of the Panda": r"distribution\(\"example-robot-data\"\)",
}
"""Facts that should occur once, each with a pattern that finds its places."""


def python_files(root: Path) -> list[Path]:
    """Return the product's Python files; links are not followed."""
    return sorted(file for name in FOLDERS for file in (root / name).rglob("*.py") if ".venv" not in file.parts)


def undocumented(tree: ast.Module) -> int:
    """Return how many public scalar constants of a module have no docstring below them."""
    count = 0
    for statement, after in zip(tree.body, [*tree.body[1:], None], strict=True):
        if not isinstance(statement, ast.Assign) or not isinstance(statement.targets[0], ast.Name):
            continue
        name, value = statement.targets[0].id, statement.value
        value = value.operand if isinstance(value, ast.UnaryOp) else value
        scalar = isinstance(value, ast.Constant) and isinstance(value.value, int | float)
        documented = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
        count += name.isupper() and scalar and not documented
    return count


def main(folder: Path = ROOT) -> None:
    """Print the counts of FOLDER."""
    texts = {file: file.read_text(encoding="utf-8") for file in python_files(folder)}
    lines = [text.count("\n") for text in texts.values()]
    print(f"files {len(texts)}, lines {sum(lines)}, median {median(lines):.0f}, longest {max(lines)}")
    print(f"argument lines that begin without a noun: {sum(len(FRAGMENT.findall(text)) for text in texts.values())}")
    print(f"public scalar constants without a docstring: {sum(undocumented(ast.parse(t)) for t in texts.values())}")
    for fact, pattern in FACTS.items():
        places = [file for file, text in texts.items() if re.search(pattern, text) and "compiled" not in file.name]
        names = ", ".join(str(file.relative_to(folder)) for file in places)
        print(f"{fact}: {len(places)} ({names})")


if __name__ == "__main__":
    run_script(main)
