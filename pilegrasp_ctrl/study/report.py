"""Recordings, pages and thumbnails of a study's attempts, beside the recordings in its folder."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from ..analysis.motion import annotate
from ..config import build_scenario
from ..exceptions import ExportError
from ..files import RECORDINGS, make_folder, read_file, write_output
from ..recording import Recording
from ..viewer.browser import viewer_script
from ..viewer.page.document import write_html
from ..viewer.pictures import chromium
from ..viewer.pictures.stills import Progress, thumbnails
from ..viewer.study.page import Links
from ..viewer.study.rows import IndexRow, read_scenario
from .own_files import is_own, note_own

MAX_PICTURE_SIZE = 1 << 20
"""Largest thumbnail that is read [bytes], chosen: fifty times the usual size."""


def record_attempts(folder: Path, rows: Sequence[IndexRow], number: int, progress: Progress) -> int:
    """Repeat and record attempts that have no recording; return how many.

    Args:
        folder: Folder of the study.
        rows: Attempts of the study.
        number: Number of successes and of failures of each condition that have a recording at the end.
        progress: Callback after each attempt.

    Raises:
        ExportError: An attempt has another result, because another version made the study, or a file cannot be written.
    """
    from .. import episode  # Pages alone load no engine.

    place = folder / RECORDINGS
    counts: dict[tuple[str, bool], int] = {}
    chosen = []
    for row in sorted(rows, key=lambda row: row.seed):
        if row.success is None:
            continue
        group = (row.config_hash, row.success)
        counts[group] = counts.get(group, 0) + 1
        if counts[group] <= number and not (place / f"{row.stem}.npz").exists():
            chosen.append(row)
    make_folder(place)
    for index, row in enumerate(chosen):
        scenario = build_scenario(dict(read_scenario(folder, row.config_hash)), source=str(folder))
        result = episode.run(scenario, seed=row.seed, record=True)
        if (result.success, result.grasped) != (row.success, row.grasped) or result.recording is None:
            raise ExportError(
                f"{folder}: seed {row.seed} of {row.config_hash} has another result now, so another version made the "
                "study; sweep again, or leave out --recordings"
            )
        annotate(result.recording).save(place / f"{row.stem}.npz")
        progress(index + 1, len(chosen))
    return len(chosen)


def write_pages(folder: Path, rows: Sequence[IndexRow], progress: Progress, shared: bool = False) -> Links:
    """Write the pages that are missing, older than their recording, or not of this program; return the links to all.

    One success and one failure of each condition have a page side by side. Thumbnails need a browser.

    Args:
        folder: Folder of the study.
        rows: Attempts of the study.
        progress: Callback after each page and each thumbnail.
        shared: Whether all pages load one file with meshcat's viewer instead of holding it.

    Raises:
        PilegraspError: A recording cannot be read, or a file cannot be written.
    """
    place = folder / RECORDINGS
    recorded = [row for row in rows if (place / f"{row.stem}.npz").is_file()]
    viewer = _write_viewer(place) if shared and recorded else None
    pages: dict[str, str] = {}
    for index, row in enumerate(recorded):
        page = place / f"{row.stem}.html"
        _write_page(page, viewer, place / f"{row.stem}.npz")
        pages[row.stem] = f"{RECORDINGS}/{page.name}"
        progress(index + 1, len(recorded))
    pairs: dict[str, str] = {}
    for config_hash in dict.fromkeys(row.config_hash for row in recorded):
        verdicts = {row.success: row for row in reversed(recorded) if row.config_hash == config_hash}
        if True in verdicts and False in verdicts:
            page = place / f"{config_hash}-pair.html"
            _write_page(page, viewer, *(place / f"{verdicts[verdict].stem}.npz" for verdict in (True, False)))
            pairs[config_hash] = f"{RECORDINGS}/{page.name}"
    return Links(pages, _draw_thumbnails(place, [row.stem for row in recorded], progress), pairs)


def _write_viewer(place: Path) -> Path:
    """Write the file with meshcat's viewer that all pages of the folder load, whatever was there; return its path."""
    content = viewer_script().encode()
    file = place / f"viewer-{hashlib.sha256(content).hexdigest()[:12]}.js"
    write_output(file, content, "viewer")
    return file


def _write_page(page: Path, viewer: Path | None, source: Path, beside: Path | None = None) -> None:
    """Write the page of one or two recordings, unless it is there as this program wrote it."""
    sources = [source] if beside is None else [source, beside]
    made_of = [*sources, *([] if viewer is None else [viewer])]
    if not is_own(page, *made_of):
        second = None if beside is None else Recording.load(beside)
        names = [one.name for one in sources]
        write_html(Recording.load(source), page, second, sources=names, viewer="" if viewer is None else viewer.name)
        note_own(page, *made_of)


def _draw_thumbnails(place: Path, stems: list[str], progress: Progress) -> dict[str, bytes]:
    """Return the thumbnails by stem; draw those that are missing. Without a browser, return {} if any is missing.

    The pages are those of `_write_page`: a browser runs the scripts of what it draws.
    """
    missing = [stem for stem in stems if not is_own(place / f"{stem}.jpg", place / f"{stem}.html")]
    if missing and chromium.find_chromium() is None:
        return {}
    drawn = thumbnails([place / f"{stem}.html" for stem in missing], progress)
    for stem, picture in zip(missing, drawn, strict=True):
        write_output(place / f"{stem}.jpg", picture, "thumbnail")
        note_own(place / f"{stem}.jpg", place / f"{stem}.html")
    return {stem: read_file(place / f"{stem}.jpg", MAX_PICTURE_SIZE, error=ExportError) for stem in stems}
