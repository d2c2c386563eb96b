"""The page of a study: success by condition, and every attempt with a link to its recording, failures first."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from string import Template

from pilegrasp_ctrl.statistics import wilson
from pilegrasp_ctrl.viewer.index_rows import IndexRow

_HERE = Path(__file__).parent


@dataclass(frozen=True, slots=True)
class Links:
    """Paths of a study's pages, relative to the page of the study, by the `stem` of the attempt.

    Attributes:
        pages: Pages of the recorded attempts.
        pictures: Pictures of their last moments, as bytes of a JPEG.
        pairs: Pages that show a success beside a failure, by config hash of the condition.
    """

    pages: Mapping[str, str] = field(default_factory=dict)
    pictures: Mapping[str, bytes] = field(default_factory=dict)
    pairs: Mapping[str, str] = field(default_factory=dict)


def _labels(rows: Sequence[IndexRow]) -> list[str]:
    return list(dict.fromkeys(label for row in rows for label, _ in row.condition))


def _condition_cells(row: IndexRow, labels: Sequence[str]) -> str:
    values = dict(row.condition)
    return "".join(f"<td>{escape(values.get(label, ''))}</td>" for label in labels)


def _condition(number: int, rows: Sequence[IndexRow], labels: Sequence[str], links: Links) -> str:
    n, successes = len(rows), sum(row.success is True for row in rows)
    low, high = wilson(successes, n)
    errors = sum(row.success is None for row in rows)
    pair = links.pairs.get(rows[0].config_hash)
    compare = f'<a href="{escape(pair)}">side by side</a>' if pair else ""
    return (
        f'<tr data-group="{number}">{_condition_cells(rows[0], labels)}'
        f'<td class="n">{n}</td><td class="n">{successes}</td>'
        f'<td class="n">{100 * successes / n:.0f} %</td><td class="n">{100 * low:.0f}–{100 * high:.0f} %</td>'
        f'<td><div class="bar" title="{successes} of {n}; 95 % interval {100 * low:.1f} to {100 * high:.1f} %">'
        f'<i style="width:{100 * successes / n:.1f}%"></i>'
        f'<b style="left:{100 * low:.1f}%;width:{100 * (high - low):.1f}%"></b></div></td>'
        f'<td class="n">{sum(row.grasped > 1 for row in rows)}</td>'
        f'<td class="n">{sum(row.triggered for row in rows)}</td><td class="n">{errors or ""}</td>'
        f'<td><button type="button" data-only="{number}">attempts</button> {compare}</td></tr>'
    )


def _attempt(number: int, row: IndexRow, labels: Sequence[str], links: Links) -> str:
    state = {True: "success", False: "failure", None: "error"}[row.success]
    page, picture = links.pages.get(row.stem), links.pictures.get(row.stem)
    shown = "open" if picture is None else ""
    if picture is not None:
        encoded = base64.b64encode(picture).decode()
        shown = f'<img alt="open the recording" width="160" height="100" src="data:image/jpeg;base64,{encoded}">'
    link = f'<a href="{escape(page)}">{shown}</a>' if page else ""
    time = "" if row.duration is None else f"{row.duration:.1f}"
    return (
        f'<tr class="{state}" data-group="{number}"><td>{link}</td><td><b class="{state}">{state}</b></td>'
        f"<td>{escape(row.words)}</td>{_condition_cells(row, labels)}"
        f'<td class="n">{row.seed}</td><td class="n">{row.grasped}</td><td class="n">{time}</td></tr>'
    )


def index_page(title: str, rows: Sequence[IndexRow], links: Links | None = None) -> str:
    """Return the study as one HTML document that loads nothing but, by its links, the pages of the recordings."""
    links = links or Links()
    labels = _labels(rows)
    groups: dict[str, list[IndexRow]] = {}
    for row in rows:
        groups.setdefault(row.config_hash, []).append(row)
    number = {config_hash: index for index, config_hash in enumerate(groups)}
    # Errors come before failures; among equals, those with a recording come first.
    rank = {None: 0, False: 1, True: 2}
    ordered = sorted(rows, key=lambda r: (rank[r.success], r.stem not in links.pages, number[r.config_hash], r.seed))
    script = (_HERE / "index.js").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    total, successes = len(rows), sum(row.success is True for row in rows)
    names = "".join(f"<th>{escape(label)}</th>" for label in labels)
    return Template((_HERE / "index.html").read_text(encoding="utf-8")).substitute(
        policy=f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data:",
        title=escape(title),
        style=(_HERE / "index.css").read_text(encoding="utf-8"),
        total=f"{total} attempt{'' if total == 1 else 's'}, {successes} successful, {len(links.pages)} recorded",
        names=names,
        conditions="".join(_condition(number[key], group, labels, links) for key, group in groups.items()),
        choices="".join(
            f'<option value="{number[key]}">{escape(", ".join(f"{a} {b}" for a, b in group[0].condition))}</option>'
            for key, group in groups.items()
        ),
        attempts="".join(_attempt(number[row.config_hash], row, labels, links) for row in ordered),
        script=script,
    )
