"""`pilegrasp export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..output_file import check_output
from .application import app
from .options import DebugOption, JsonOption, print_json


@app.command("export")
def export_recording(
    recording: Annotated[Path, typer.Argument(metavar="F.npz", help="What `pilegrasp run --record` wrote.")],
    html: Annotated[Path, typer.Argument(metavar="F.html", help="The page to write.")],
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Turn a recording into a page that shows the attempt in any browser, offline."""
    check_output(html, ".html")

    from ..recording import Recording
    from ..viewer import write_html

    write_html(Recording.load(recording), html)
    if as_json:
        print_json({"recording": str(recording), "html": str(html), "bytes": html.stat().st_size})
    else:
        print(html)
