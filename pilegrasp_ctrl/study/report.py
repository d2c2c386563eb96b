"""Recordings, pages and thumbnails of a study's attempts, beside the recordings in its folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..analysis.motion import annotate
from ..config import build_scenario
from ..exceptions import ExportError
from ..files import RECORDINGS, make_folder, write_output
from ..recording import Recording
from ..viewer import chromium
from ..viewer.html import write_html
from ..viewer.index import Links
from ..viewer.index_rows import IndexRow, read_scenario
from ..viewer.stills import Progress, thumbnails


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


def write_pages(folder: Path, rows: Sequence[IndexRow], progress: Progress) -> Links:
    """Write the pages that are missing or older than their recording, and return the links to all.

    One success and one failure of each condition have a page side by side. Thumbnails need a browser.

    Raises:
        PilegraspError: A recording cannot be read, or a file cannot be written.
    """
    place = folder / RECORDINGS
    recorded = [row for row in rows if (place / f"{row.stem}.npz").is_file()]
    pages: dict[str, str] = {}
    for index, row in enumerate(recorded):
        source, page = place / f"{row.stem}.npz", place / f"{row.stem}.html"
        if not _is_newer(page, source):
            write_html(Recording.load(source), page)
        pages[row.stem] = f"{RECORDINGS}/{page.name}"
        progress(index + 1, len(recorded))
    pairs: dict[str, str] = {}
    for config_hash in dict.fromkeys(row.config_hash for row in recorded):
        verdicts = {row.success: row for row in reversed(recorded) if row.config_hash == config_hash}
        if True in verdicts and False in verdicts:
            sources = [place / f"{verdicts[verdict].stem}.npz" for verdict in (True, False)]
            page = place / f"{config_hash}-pair.html"
            if not all(_is_newer(page, source) for source in sources):
                first, second = map(Recording.load, sources)
                write_html(first, page, second)
            pairs[config_hash] = f"{RECORDINGS}/{page.name}"
    return Links(pages, _draw_thumbnails(place, [row.stem for row in recorded], progress), pairs)


def _draw_thumbnails(place: Path, stems: list[str], progress: Progress) -> dict[str, bytes]:
    """Return the thumbnails by stem; draw those that are missing. Without a browser, return {} if any is missing."""
    missing = [stem for stem in stems if not _is_newer(place / f"{stem}.jpg", place / f"{stem}.html")]
    if missing and chromium.find_chromium() is None:
        return {}
    drawn = thumbnails([place / f"{stem}.html" for stem in missing], progress)
    for stem, picture in zip(missing, drawn, strict=True):
        write_output(place / f"{stem}.jpg", picture, "thumbnail")
    return {stem: (place / f"{stem}.jpg").read_bytes() for stem in stems}


def _is_newer(made: Path, source: Path) -> bool:
    return made.is_file() and made.stat().st_mtime_ns >= source.stat().st_mtime_ns
