"""The page of a study: success by condition, failures by reason, and every attempt with a link to its recording."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from markupsafe import Markup

from pilegrasp_ctrl.statistics import wilson
from pilegrasp_ctrl.viewer.browser import STUDY_SCRIPTS, digest, own_script
from pilegrasp_ctrl.viewer.study.orders import Estimate, Orders, orders_of
from pilegrasp_ctrl.viewer.study.picks import kind_of_reason
from pilegrasp_ctrl.viewer.study.pivots import labels_of, pivots, reasons
from pilegrasp_ctrl.viewer.study.rows import IndexRow
from pilegrasp_ctrl.viewer.templates import render, trusted

VERDICTS = {True: "success", False: "failure", None: "error"}
"""Word for each value of `IndexRow.success`."""

DRAWN = 300
"""Number of attempts that are drawn before a reader scrolls; chosen, so that a page of thousands opens at once."""


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


def index_page(title: str, rows: Sequence[IndexRow], links: Links | None = None) -> str:
    """Return the study as one HTML document that loads nothing but, by its links, the pages of the recordings."""
    links = links or Links()
    values = labels_of(rows)
    varied = [label for label, found in values.items() if len(found) > 1 or not _is_in_all(label, rows)]
    groups: dict[str, list[IndexRow]] = {}
    for row in rows:
        groups.setdefault(row.config_hash, []).append(row)
    number = {config_hash: index for index, config_hash in enumerate(groups)}
    # Errors come before failures; among equals, those with a recording come first.
    rank = {None: 0, False: 1, True: 2}
    ordered = sorted(rows, key=lambda r: (rank[r.success], r.stem not in links.pages, number[r.config_hash], r.seed))
    script = own_script(*STUDY_SCRIPTS)
    lost = reasons(rows)
    kinds = {words: index for index, (words, _) in enumerate(lost)}
    return str(
        render(
            "study/index.html",
            policy=f"default-src 'none'; script-src {digest(script)}; style-src 'unsafe-inline'; img-src data:",
            title=title,
            style=trusted("study/index.css"),
            script=Markup(script),
            total=len(rows),
            successes=sum(row.success is True for row in rows),
            recorded=len(links.pages),
            drawn=DRAWN,
            orders=[_orders(found, varied) for found in orders_of(rows)],
            losses_known=any(row.lost is not None for row in rows),
            common={label: found[0] for label, found in values.items() if label not in varied},
            labels=varied,
            conditions=[_condition(number[key], group, varied, links) for key, group in groups.items()],
            reasons=[(kinds[words], words, n) for words, n in lost],
            failures=sum(n for _, n in lost),
            attempts=[_attempt(number[row.config_hash], row, varied, links, kinds) for row in ordered],
            pivots=Markup(json.dumps(pivots(rows), separators=(",", ":")).replace("<", "\\u003c")),
        )
    )


def _is_in_all(label: str, rows: Sequence[IndexRow]) -> bool:
    return all(label in row.values for row in rows)


def _cells(row: IndexRow, labels: Sequence[str]) -> list[str]:
    values = row.values
    return [values.get(label, "") for label in labels]


def _condition(number: int, rows: Sequence[IndexRow], labels: Sequence[str], links: Links) -> dict[str, Any]:
    n, successes = len(rows), sum(row.success is True for row in rows)
    low, high = wilson(successes, n)
    return {
        "number": number,
        "name": ", ".join(f"{label} {value}" for label, value in rows[0].condition),
        "cells": _cells(rows[0], labels),
        "n": n,
        "successes": successes,
        "rate": 100 * successes / n,
        "low": 100 * low,
        "high": 100 * high,
        "multiple": sum(row.grasped > 1 for row in rows),
        "triggered": sum(row.triggered for row in rows),
        "errors": sum(row.success is None for row in rows),
        "pair": links.pairs.get(rows[0].config_hash),
    }


def _orders(found: Orders, labels: Sequence[str]) -> dict[str, Any]:
    name = ", ".join(f"{label} {value}" for label, value in found.condition if label in labels)
    return {
        "name": name,
        "completed": f"{found.completed} of {found.n}",
        "limits": "{:.0f}–{:.0f} %".format(*(100 * end for end in found.limits)),
        "attempts": _estimate(found.attempts, 1),
        "picks": _estimate(found.picks_an_hour, 0),
        "tries": found.tries,
        "wrong": [(words, count, 100 * count / found.tries) for words, count in found.wrong],
        "right": found.tries - sum(count for _, count in found.wrong),
    }


def _estimate(found: Estimate | None, digits: int) -> tuple[str, str]:
    """Return a value and its interval as text."""
    if found is None:
        return "–", ""
    value, low, high = (f"{each:.{digits}f}" for each in found)
    return value, f"{low} to {high}" if math.isfinite(found[2]) else "one order has no interval"


def _attempt(
    number: int, row: IndexRow, labels: Sequence[str], links: Links, kinds: Mapping[str, int]
) -> dict[str, Any]:
    picture = links.pictures.get(row.stem)
    return {
        "number": number,
        "reason": "" if row.success else kinds[kind_of_reason(row.words)],
        "verdict": VERDICTS[row.success],
        "words": row.words,
        "cells": _cells(row, labels),
        "seed": row.seed,
        "grasped": row.grasped,
        "lost": "" if row.lost is None else row.lost,
        "duration": "" if row.duration is None else f"{row.duration:.1f}",
        "page": links.pages.get(row.stem),
        "picture": None if picture is None else base64.b64encode(picture).decode(),
    }
