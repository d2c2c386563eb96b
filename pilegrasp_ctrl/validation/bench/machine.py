"""What a run of the benchmark was made on; its times mean little without."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from ... import __version__
from .result import Settings

PACKAGES = ("pin", "mujoco", "numpy", "daqp", "osqp", "qpsolvers", "mink", "pin-pink", "tsid")


def settings_of(scenario: str, seeds: tuple[int, ...], quick: bool) -> Settings:
    """Return how this run is made, and on what."""
    return Settings(
        quick=quick,
        threads=os.environ.get("OMP_NUM_THREADS", ""),
        processors=len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1,
        load=os.getloadavg()[0],
        processor=_processor(),
        scenario=scenario,
        seeds=seeds,
    )


def _processor() -> str:
    """Return the processor's name where the system tells it, else the architecture."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


def versions() -> dict[str, str]:
    """Return the versions of what takes part, as far as it is installed."""
    found = {"pilegrasp": __version__, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found
