"""A saved result of the benchmark as Markdown: the tables of docs/benchmark.md.

Usage: python -m pilegrasp_ctrl.experiments.bench.markdown F.json
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from .result import BenchResult, load_result


def markdown(result: BenchResult) -> str:
    """Return the tables of ticks, stages, memory, closed loop, imports and targets."""
    settings = result.settings
    versions = ", ".join(f"{name} {number}" for name, number in result.versions.items())
    load = f"{settings.processors} processors, load {settings.load:.1f} at the start"
    parts = [f"Measured on {settings.processor}, {load}; {versions}."]
    for title, kind in (
        ("tick, ratio to the yardstick", "tick"),
        ("peer, ratio to the operational-space tick", "peer"),
        ("stage of the operational-space tick, ratio to the yardstick", "stage"),
        ("fresh interpreter, ratio to `import numpy`", "import"),
    ):
        unit = "ms" if kind == "import" else "us"
        head: tuple[str, ...] = (title, "ratio", "±", f"median [{unit}]", "p99", "max", "tail")
        parts.append(_table(head, (_cells(result, key) for key in _keys(result, kind))))
    head = ("memory of a tick", "peak [B]", "kept by the answer [B]", "growth [B]", "in ticks")
    memory = result.memory
    parts.append(
        _table(
            head, ((row.key, *_whole(row.peak_bytes, row.kept_bytes, row.growth_bytes, row.ticks)) for row in memory)
        )
    )
    head = (f"`{settings.scenario}`, per control period", "loop / bare", "10 to 90 %", "loop [us]", "bare", "control")
    head += ("glue", "x real time")
    loop = (
        (
            row.phase,
            f"{row.ratio:.2f}",
            f"{row.ratio_p10:.2f} to {row.ratio_p90:.2f}",
            *_whole(row.period_us, row.bare_us, row.control_us, row.glue_us),
            f"{row.realtime_factor:.1f}",
        )
        for row in result.loop
    )
    parts.append(_table(head, loop))
    verdicts = {True: "met", False: "not met", None: "not measured"}
    targets = (
        (row.name, "" if row.value is None else f"{row.value:.2f}", f"{row.relation} {row.bound:g}", verdicts[row.met])
        for row in result.targets
    )
    parts.append(_table(("target", "measured", "bound", "verdict"), targets))
    return "\n\n".join(part for part in parts if part)


def _keys(result: BenchResult, kind: str) -> list[str]:
    return [row.key for row in result.rows if row.table == kind]


def _cells(result: BenchResult, key: str) -> tuple[str, ...]:
    row = result.row(key)
    if row is None or not row.count:
        return (key, "not installed", *("",) * 5)
    ratio = "" if row.ratio is None else f"{row.ratio:.2f}"
    spread = "" if row.spread is None else f"{100.0 * row.spread:.0f} %"
    scale = 1e-3 if row.table == "import" else 1.0
    times = ("" if value is None else f"{scale * value:.1f}" for value in (row.median_us, row.p99_us, row.worst_us))
    return (key, ratio, spread, *times, "" if row.tail is None else f"{row.tail:.2f}")


def _whole(*values: float) -> tuple[str, ...]:
    return tuple(f"{value:.0f}" for value in values)


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    """Return a table, or nothing where there are no rows."""
    lines = [_line(row) for row in rows]
    return "\n".join([_line(head), f"|{'---|' * len(head)}", *lines]) if lines else ""


def _line(cells: tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    print(markdown(load_result(Path(sys.argv[1]))))
