"""`pilegrasp report`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..exceptions import ExportError
from .application import DebugOption, JsonOption, app, print_json
from .export import drawing_progress

if TYPE_CHECKING:
    from ..viewer.index import Links
    from ..viewer.index_rows import AttemptRow


@app.command(
    "report",
    epilog="Pages of recordings lie beside them in DIR/recordings, and are kept while they are newer than those. "
    "Thumbnails are drawn by Chromium; without one the page has links instead.",
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
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Write DIR/index.html: success by condition, every attempt, and its recording where there is one."""
    from ..files import check_output, write_output
    from ..viewer.index import index_page
    from ..viewer.index_rows import read_attempts

    rows = read_attempts(folder)
    output = folder / "index.html"
    check_output(output, ".html")
    made = _record(folder, rows, recordings) if recordings else 0
    links = _links(folder, rows)
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
            }
        )
    else:
        print(output)


def _record(folder: Path, rows: list[AttemptRow], number: int) -> int:
    """Repeat attempts that have no recording; each comes out as it did, or the study is of another version."""
    from ..analysis.motion import annotate
    from ..config import build_scenario
    from ..episode import run
    from ..files import make_folder
    from ..viewer.index_rows import RECORDINGS, read_scenario

    place = folder / RECORDINGS
    counts: dict[tuple[str, bool], int] = {}
    chosen = []
    for row in sorted(rows, key=lambda row: row.seed):
        if row.success is None:
            continue
        kind = (row.config_hash, row.success)
        counts[kind] = counts.get(kind, 0) + 1
        if counts[kind] <= number and not (place / f"{row.stem}.npz").exists():
            chosen.append(row)
    make_folder(place)
    with drawing_progress(place) as progress:
        for index, row in enumerate(chosen):
            scenario = build_scenario(dict(read_scenario(folder, row.config_hash)), source=str(folder))
            result = run(scenario, seed=row.seed, record=True)
            if (result.success, result.grasped) != (row.success, row.grasped) or result.recording is None:
                raise ExportError(
                    f"{folder}: seed {row.seed} of {row.config_hash} comes out differently now, so the study "
                    "was made by another version; sweep again, or leave out --recordings"
                )
            annotate(result.recording).save(place / f"{row.stem}.npz")
            progress(index + 1, len(chosen))
    return len(chosen)


def _links(folder: Path, rows: list[AttemptRow]) -> Links:
    """Write the pages that are missing or older than their recording, and find all."""
    from ..recording import Recording
    from ..viewer.html import write_html
    from ..viewer.index import Links
    from ..viewer.index_rows import RECORDINGS

    place = folder / RECORDINGS
    recorded = [row for row in rows if (place / f"{row.stem}.npz").is_file()]
    pages: dict[str, str] = {}
    with drawing_progress(place) as progress:
        for index, row in enumerate(recorded):
            source, page = place / f"{row.stem}.npz", place / f"{row.stem}.html"
            if not _newer(page, source):
                write_html(Recording.load(source), page)
            pages[row.stem] = f"{RECORDINGS}/{page.name}"
            progress(index + 1, len(recorded))
    pairs: dict[str, str] = {}
    for config_hash in dict.fromkeys(row.config_hash for row in recorded):
        verdicts = {row.success: row for row in reversed(recorded) if row.config_hash == config_hash}
        if True in verdicts and False in verdicts:
            sources = [place / f"{verdicts[verdict].stem}.npz" for verdict in (True, False)]
            page = place / f"{config_hash}-pair.html"
            if not all(_newer(page, source) for source in sources):
                first, second = map(Recording.load, sources)
                write_html(first, page, second)
            pairs[config_hash] = f"{RECORDINGS}/{page.name}"
    return Links(pages, _pictures(place, [row.stem for row in recorded]), pairs)


def _pictures(place: Path, stems: list[str]) -> dict[str, bytes]:
    """Return the thumbnails by stem, drawing those that are missing where a browser is found."""
    from ..files import write_output
    from ..viewer.chromium import find_chromium
    from ..viewer.stills import thumbnails

    missing = [stem for stem in stems if not _newer(place / f"{stem}.jpg", place / f"{stem}.html")]
    if missing and find_chromium() is None:
        return {}
    with drawing_progress(place) as progress:
        drawn = thumbnails([place / f"{stem}.html" for stem in missing], progress)
    for stem, picture in zip(missing, drawn, strict=True):
        write_output(place / f"{stem}.jpg", picture, "thumbnail")
    return {stem: (place / f"{stem}.jpg").read_bytes() for stem in stems}


def _newer(made: Path, source: Path) -> bool:
    return made.is_file() and made.stat().st_mtime_ns >= source.stat().st_mtime_ns
