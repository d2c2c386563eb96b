"""`pilegrasp list`."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.markup import escape
from rich.table import Table

from ..exceptions import ConfigurationError
from .application import DebugOption, JsonOption, app, make_console, print_json, with_examples


@app.command("list", epilog=with_examples("", "pilegrasp list --tag paper"))
def list_scenarios(
    tag: Annotated[str | None, typer.Option(metavar="TAG", help="Only the scenarios with this tag.")] = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """List the scenarios that `run` knows by name."""
    from ..config import load_scenario
    from ..scenarios import names

    scenarios = [load_scenario(name) for name in names()]
    tags = sorted({known for scenario in scenarios for known in scenario.tags})
    if tag is not None and tag not in tags:
        raise ConfigurationError(f"no scenario has the tag {tag!r}; the tags are {', '.join(tags)}")
    rows = [scenario for scenario in scenarios if tag is None or tag in scenario.tags]
    if as_json:
        print_json([{"name": row.name, "tags": list(row.tags), "summary": row.summary} for row in rows])
        return
    table = Table(box=None, pad_edge=False)
    # A narrow terminal breaks the summaries; a name stays whole, to be copied.
    table.add_column("scenario", no_wrap=True, overflow="ignore")
    for column in ("tags", "summary"):
        table.add_column(column)
    for row in rows:
        table.add_row(escape(row.name), escape(" ".join(row.tags)), escape(row.summary))
    make_console().print(table)
