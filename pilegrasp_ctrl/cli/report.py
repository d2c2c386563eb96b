"""`pilegrasp report`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..plugins import use_plugins
from .application import DebugOption, JsonOption, PluginsOption, app, print_json, with_examples
from .export import drawing_progress


@app.command(
    "report",
    epilog=with_examples(
        "Pages of recordings lie beside them in DIR/recordings; one that this command did not write is made anew. "
        "Thumbnails are drawn by Chromium; without one the page has links instead.",
        "pilegrasp report study",
        "pilegrasp report study --recordings 1 --shared",
    ),
)
def report_study(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a study, as `pilegrasp sweep` made it.")],
    recordings: Annotated[
        int,
        typer.Option(
            min=0,
            metavar="N",
            help="Repeat and record up to N successes and N failures of each condition that have no recording.",
        ),
    ] = 0,
    shared: Annotated[
        bool,
        typer.Option(
            "--shared",
            metavar="",
            help="Let the pages of recordings load one viewer from DIR/recordings, which saves 0.85 MB a page.",
        ),
    ] = False,
    plugins: PluginsOption = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Write DIR/index.html: success by condition, every attempt, and its recording if there is one."""
    from ..files import RECORDINGS, check_output, write_output
    from ..viewer.study.orders import orders_of
    from ..viewer.study.page import index_page
    from ..viewer.study.rows import read_attempts

    use_plugins(plugins or ())
    rows = read_attempts(folder)
    output = folder / "index.html"
    check_output(output, ".html")

    from ..study.report import record_attempts, write_pages

    made = 0
    if recordings:
        with drawing_progress(folder / RECORDINGS) as progress:
            made = record_attempts(folder, rows, recordings, progress)
    with drawing_progress(folder / RECORDINGS) as progress:
        links = write_pages(folder, rows, progress, shared)
    document = index_page(folder.resolve().name or "study", rows, links)
    write_output(output, document.encode("utf-8", errors="replace"), "page")
    if as_json:
        print_json(
            {
                "study": str(folder),
                "html": str(output),
                "attempts": len(rows),
                "successes": sum(row.success is True for row in rows),
                "recordings": len(links.pages),
                "recorded_now": made,
                "thumbnails": len(links.pictures),
                "orders": [found.as_dict() for found in orders_of(rows)],
            }
        )
    else:
        print(output)
