"""A recording of any size takes time in proportion to it, or is answered by one sentence with the limit."""

import io
import json
import time
import zipfile
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from pilegrasp_ctrl.analysis.carried import Carried, carried, emptied
from pilegrasp_ctrl.analysis.motion import measure_attempt
from pilegrasp_ctrl.exceptions import ExportError, RecordingError
from pilegrasp_ctrl.recording import MAX_ENTRIES, MAX_HEADER, Body, Recording, Shape
from pilegrasp_ctrl.viewer.page.attempts import attempt_motions
from pilegrasp_ctrl.viewer.page.document import page
from pilegrasp_ctrl.viewer.page.events import events
from pilegrasp_ctrl.viewer.page.limits import MAX_ATTEMPTS, MAX_BODIES, MAX_PRIMITIVES, MAX_SHAPES
from pilegrasp_ctrl.viewer.page.summary import attempt_rows, summarize
from pilegrasp_ctrl.viewer.page.timeline import MAX_ROWS, rows_of, styles
from pilegrasp_ctrl.viewer.pictures.contact_sheet import MAX_TILES, moments
from pilegrasp_ctrl.viewer.scene.animation import thin
from pilegrasp_ctrl.viewer.scene.camera import MAX_COVERS, MAX_ENDS, best_direction
from synthetic_order import synthetic_order
from synthetic_recording import synthetic

LIMIT = 60.0
"""Most processor time of a block [s]: ten times what it takes if it is linear, a tenth of what it takes if not."""


@contextmanager
def bounded():
    begin = time.process_time()
    yield
    assert time.process_time() - begin < LIMIT


def many_bodies(count, frames=3, role="object"):
    """Return the synthetic attempt with so many bodies more."""
    small = synthetic(frames=frames, objects=2)
    bodies = tuple(Body(f"more_{k}", role, (Shape("sphere", (0.03,)),)) for k in range(count))
    position, quaternion = small.body_position, small.body_quaternion
    return replace(
        small,
        bodies=(*small.bodies, *bodies),
        body_position=np.concatenate([position, np.repeat(position[:, -3:-2], count, axis=1)], axis=1),
        body_quaternion=np.concatenate([quaternion, np.repeat(quaternion[:, -3:-2], count, axis=1)], axis=1),
    )


def many_outcomes(count, name="push", **more):
    rows = [
        {"name": f"{name}{k % 1000}" if more else name, "start": 5e-6 * k, "end": 5e-6 * (k + 1)} | more
        for k in range(count)
    ]
    return replace(synthetic(frames=30), meta=synthetic(frames=3).meta | {"outcomes": rows})


@pytest.mark.slow
def test_twenty_thousand_bodies_are_read_and_measured_in_linear_time_and_are_too_many_for_a_page(tmp_path):
    file = tmp_path / "a.npz"
    with bounded():
        many_bodies(20_000, frames=30).save(file)
        recording = Recording.load(file)
        assert measure_attempt(recording)["motion"]["hand_speed"] > 0.0
        with pytest.raises(ExportError, match=rf"holds 200\d\d bodies, and a page shows {MAX_BODIES} at most"):
            page(recording)


@pytest.mark.slow
def test_the_largest_number_of_bodies_of_any_role_makes_a_page_in_linear_time():
    for role in ("object", "support"):
        recording = many_bodies(MAX_BODIES - 60, role=role)
        with bounded():
            assert page(recording).endswith("</html>\n")


@pytest.mark.slow
def test_two_hundred_thousand_outcomes_are_measured_in_linear_time_and_are_too_many_for_a_page():
    recording = many_outcomes(200_000, status="failed", trigger="limit")
    with bounded():
        measure_attempt(recording)
        assert len(moments(recording)) <= MAX_TILES
        summary = summarize(recording.meta)
        assert len(styles(summary.primitives)) == 200_000
        assert len(events(recording, summary)) == 200_000
        with pytest.raises(ExportError, match=f"holds 200000 outcomes, and a page shows {MAX_PRIMITIVES} at most"):
            page(recording)


@pytest.mark.slow
def test_the_largest_number_of_outcomes_and_attempts_makes_a_page_in_linear_time():
    order = synthetic_order(frames=30)
    rows = [{"name": "lift", "start": 7e-3 * k, "end": 7e-3 * k + 30.0} for k in range(MAX_PRIMITIVES)]
    # Every attempt lasts to the end, and they begin to and fro.
    attempts = [{"start": 0.06 * (k if k % 2 else MAX_ATTEMPTS - k), "end": 36.0} for k in range(MAX_ATTEMPTS)]
    order = replace(order, meta=order.meta | {"outcomes": rows, "attempts": attempts})
    with bounded():
        assert page(order).endswith("</html>\n")
    with pytest.raises(ExportError, match=f"holds {MAX_ATTEMPTS + 1} attempts"):
        page(replace(order, meta=order.meta | {"attempts": [*attempts, attempts[0]]}))


def test_many_shapes_are_too_many_for_a_page():
    shape = Shape("sphere", (0.01,))
    bodies = list(synthetic(frames=3).bodies)
    bodies[-1] = Body("heap", "support", (shape,) * MAX_SHAPES)
    with pytest.raises(ExportError, match=rf"holds 100\d\d shapes, and a page shows {MAX_SHAPES} at most"):
        page(replace(synthetic(frames=3), bodies=tuple(bodies)))


@pytest.mark.slow
def test_a_camera_looks_at_a_bounded_number_of_shapes_and_moments():
    shapes = (Shape("box", (0.01, 0.01, 0.01)),) * (20 * MAX_COVERS)
    recording = many_outcomes(20 * MAX_ENDS)
    bodies = list(recording.bodies)
    bodies[-1] = Body("heap", "support", shapes)
    with bounded():
        direction = best_direction(replace(recording, bodies=tuple(bodies)))
    assert np.linalg.norm(direction) == pytest.approx(1.0)


def test_objects_and_releases_of_any_number_give_what_was_carried_in_linear_time():
    time_of, count = np.linspace(0.0, 2.0, 21), 20_000
    tool = np.stack([np.zeros(21), np.zeros(21), 0.2 * time_of], axis=1)
    objects = np.repeat(tool[:, None], count, axis=1)
    objects[-6:, :, 0] += 5.0
    releases = [(1e-6 * k, 1e-6 * k + 1e-7) for k in range(200_000)]
    with bounded():
        found = carried(time_of, tool, objects, [f"ball_{k}" for k in range(count)], (), releases)
        assert rows_of(found) == [*range(MAX_ROWS - 1), *[MAX_ROWS - 1] * (count - MAX_ROWS + 1)]
    assert {one.ending for one in found} == {"lost"}


def test_many_attempts_that_hold_nothing_are_emptied_in_linear_time():
    losses = [Carried(f"ball_{k}", 1.0, 1.0 + 1e-5 * k, "lost") for k in range(100_000)]
    spans = [(1e-5 * k, 1.0 + 1e-5 * k) for k in range(100_000)]
    with bounded():
        moments_of = emptied(synthetic(frames=30), losses, spans)
    assert moments_of == [loss.end for loss in losses]


def test_attempts_are_shown_in_the_order_of_their_starts_and_do_not_overlap():
    rows = [{"start": 24.0, "end": 34.0}, {"start": 0.0, "end": 99.0}, {"start": 12.0, "end": 23.0}, {"start": "x"}]
    assert [(row.number, row.start) for row in attempt_rows(rows)] == [(1, 0.0), (2, 12.0), (3, 24.0)]
    order = synthetic_order(frames=60)
    order = replace(order, meta=order.meta | {"attempts": rows})
    spans = [(motion.start, motion.end) for motion in attempt_motions(order, summarize(order.meta))]
    assert spans == [(0.0, 12.0), (12.0, 24.0), (24.0, float(order.frame_time[-1]))]


def test_a_motion_that_gives_up_one_frame_at_a_time_is_thinned_in_linear_time():
    count = 50_000
    lengths = []

    def error(first, last):
        lengths.append(last - first)
        found = np.zeros(last - first - 1)
        found[0] = 1.0  # the worst point is always the first
        return found

    assert len(thin(count, error, 0.5)) == count
    assert sum(lengths) < 2_100 * count


# --- files ------------------------------------------------------------------------------------------------------------


def rewritten(header, file, entries=()):
    """Write the synthetic recording with another header and further entries."""
    synthetic(frames=3).save(file)
    with zipfile.ZipFile(file) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    buffer = io.BytesIO()
    np.save(buffer, np.array(header))
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as made:
        for name, data in {**content, "header.npy": buffer.getvalue(), **dict.fromkeys(entries, b"")}.items():
            made.writestr(name, data)
    return file


def test_a_header_without_end_is_refused_before_it_is_read_and_before_it_is_written(tmp_path):
    text = json.dumps({"format": "pilegrasp-recording", "meta": "a" * (MAX_HEADER + 1000)})
    with pytest.raises(RecordingError, match=rf"meta and bodies take \d+ characters; a file holds {MAX_HEADER}"):
        Recording.load(rewritten(text, tmp_path / "a.npz"))
    long = replace(synthetic(frames=3), meta={"a": "a" * MAX_HEADER})
    with pytest.raises(RecordingError, match=f"characters; a file holds {MAX_HEADER} at most"):
        long.save(tmp_path / "b.npz")
    assert not (tmp_path / "b.npz").exists()


def test_an_archive_of_very_many_entries_is_refused(tmp_path):
    file = rewritten("{}", tmp_path / "a.npz", [f"signal/{k}.npy" for k in range(MAX_ENTRIES)])
    with pytest.raises(RecordingError, match=f"more than {MAX_ENTRIES} entries"):
        Recording.load(file)
    rewritten("{}", file)
    with zipfile.ZipFile(file, "a") as archive:
        archive.comment = b"and so on"
    with pytest.raises(RecordingError, match="or is not one of numpy's"):
        Recording.load(file)


def test_a_large_file_is_refused_before_it_is_read(tmp_path):
    file = tmp_path / "a.npz"
    with file.open("wb") as content:
        content.truncate(1 << 40)
    with pytest.raises(RecordingError, match=r"a\.npz: is too large for a file; at most 256 MiB are read$"):
        Recording.load(file)


def test_a_name_without_end_is_refused():
    with pytest.raises(RecordingError, match="a body's name has 5001 characters; at most 300 are allowed"):
        Body("a" + "9" * 5000, "hand", ())
