"""`pilegrasp export`."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

from ..exceptions import ExportError
from ..files import VIEWS, check_output
from .application import DebugOption, JsonOption, app, print_json, with_examples
from .progress import make_progress

EmbedOption = Annotated[
    bool, typer.Option("--embed-recording", metavar="", help="Put the recording into the page, for its reader to save.")
]
"""The option of verbs that write a page."""

MOVIES = (".gif", ".mp4")
"""Suffixes of movies."""


@app.command(
    "export",
    epilog=with_examples(
        "Pictures and movies are drawn by Chromium, an .mp4 is encoded by ffmpeg; a page needs neither. "
        "F.csv holds the signals, F.rrd is for Rerun, F.mcap for Foxglove; the last two need pilegrasp[export]. "
        "The folder of a study becomes a table: F.csv, or F.parquet, which needs pyarrow.",
        "pilegrasp export grasp.npz grasp.html",
        "pilegrasp export grasp.npz slow.gif --speed 0.5",
        "pilegrasp export study table.csv",
    ),
)
def export_recording(
    recordings: Annotated[
        list[Path],
        typer.Argument(
            metavar="F.npz [G.npz]|DIR",
            help="What `run --record` or `sweep` wrote; a page shows two recordings side by side.",
        ),
    ],
    output: Annotated[
        Path,
        typer.Argument(
            metavar="F.html|F.png|...",
            help="The file to write. Its name says what: a page (.html), contact sheet (.png), movie (.gif, .mp4), "
            "table (.csv, .parquet) or log (.rrd, .mcap).",
        ),
    ],
    speed: Annotated[
        float | None, typer.Option(metavar="X", help="Speed of a movie in times real time, as in 0.5.")
    ] = None,
    embed_recording: EmbedOption = False,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Turn a recording into a page that shows the attempt in any browser, a picture, a movie, a table or a log.

    Turn a study into a table.
    """
    if len(recordings) == 1 and os.path.isdir(recordings[0]):
        if speed is not None:
            raise ExportError(f"--speed is for movies ({' and '.join(MOVIES)}); leave it out for a table")
        if embed_recording:
            raise ExportError("--embed-recording is for pages (.html); leave it out for a table")
        _export_study(recordings[0], output, as_json)
        return
    check_output(output, *VIEWS)
    if len(recordings) > 2 or (len(recordings) == 2 and output.suffix != ".html"):
        raise ExportError(
            f"{len(recordings)} recordings are given for {output.name}; give one, or two for a page (.html)"
        )
    if embed_recording and output.suffix != ".html":
        raise ExportError(f"--embed-recording is for pages (.html); leave it out for {output.name}")
    if speed is not None and output.suffix not in MOVIES:
        raise ExportError(f"--speed is for movies ({' and '.join(MOVIES)}); leave it out for {output.name}")

    from ..recording import Recording
    from ..viewer import require_programs, write

    require_programs(output)
    first, *others = map(Recording.load, recordings)
    with drawing_progress(output) as progress:
        write(
            first,
            output,
            beside=others[0] if others else None,
            speed=1.0 if speed is None else speed,
            progress=progress,
            embed_recording=embed_recording,
            sources=[] if embed_recording else [os.path.relpath(source, output.parent) for source in recordings],
        )
    if as_json:
        named = {"recording": str(recordings[0])} | ({"beside": str(recordings[1])} if others else {})
        print_json({**named, output.suffix[1:]: str(output), "bytes": output.stat().st_size})
    else:
        print(output)


def _export_study(folder: Path, output: Path, as_json: bool) -> None:
    from ..study.store import StudyStore
    from ..study.table import TABLES, require_parquet, write_table

    check_output(output, *TABLES)
    if output.suffix == ".parquet":
        require_parquet()
    with StudyStore(folder) as store:
        attempts = write_table(store, output)
    if as_json:
        print_json({"study": str(folder), output.suffix[1:]: str(output), "attempts": attempts})
    else:
        print(output)


@contextmanager
def drawing_progress(path: Path) -> Iterator[Callable[[int, int], None]]:
    """Show on standard error how many pictures are drawn."""
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with make_progress(*columns) as bar:
        line = bar.add_task(f"drawing {path.name}", total=None)
        yield lambda done, total: bar.update(line, completed=done, total=total)
