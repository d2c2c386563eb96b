"""What the hand carried: taken with the lift, kept to the end, released when the hand opens, otherwise lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pilegrasp_ctrl.analysis.carried import carried, carried_in, count_carried, emptied, releases_in
from synthetic_recording import synthetic

TIME = np.arange(0.0, 8.0, 1.0 / 30.0)


def lift(start=2.0, end=4.0, height=0.2):
    """Heights of a hand that lies on the table, rises, and stays."""
    return 0.02 + height * np.clip((TIME - start) / (end - start), 0.0, 1.0)


def tool():
    return np.stack([np.full_like(TIME, 0.6), np.zeros_like(TIME), lift()], axis=1)


def with_hand(until=np.inf):
    """An object that goes with the hand and falls to the table at a time."""
    path = tool() + np.array([0.0, 0.02, 0.01])
    fallen = np.maximum(0.03, path[:, 2] - 4.9 * np.maximum(TIME - until, 0.0) ** 2)
    path[:, 2] = np.where(until < TIME, fallen, path[:, 2])
    return path


def found(*paths, **more):
    return carried(TIME, tool(), np.stack(paths, axis=1), [f"object_{k}" for k in range(len(paths))], **more)


def test_an_object_that_rises_with_the_hand_is_kept():
    (one,) = found(with_hand())
    assert (one.object, one.ending) == ("object_0", "kept")
    # The hand counts as down for 2 of the 20 cm, and must then rise by 3 with the object.
    assert one.start == pytest.approx(2.5, abs=0.05)
    assert one.end == TIME[-1]


def test_an_object_that_falls_is_lost_at_the_moment_at_which_it_slips():
    kept, lost = found(with_hand(), with_hand(until=3.3))
    assert (kept.ending, lost.ending) == ("kept", "lost")
    assert lost.end == pytest.approx(3.3, abs=0.07)
    counts = count_carried([kept, lost])
    assert counts == {
        "taken": 2,
        "kept": 1,
        "released": 0,
        "lost": 1,
        "losses": [{"object": "object_1", "time": lost.end}],
    }


def test_what_leaves_an_opened_hand_is_released():
    (one,) = found(with_hand(until=6.0), releases=[(5.9, 7.0)])
    assert one.ending == "released"


def test_an_object_on_the_table_and_one_on_a_heap_are_not_carried():
    still = np.tile([0.6, 0.0, 0.03], (TIME.size, 1))
    # An object climbs 6 cm on its neighbours while the hand pushes along the table.
    climbing = still + np.outer(np.clip(TIME, 0.0, 1.0), [0.0, 0.0, 0.06])
    assert found(still, climbing) == ()


def test_a_second_attempt_counts_from_its_own_start():
    # In the first attempt the object is lifted and put on a box; in the second it stays there.
    high = np.array(tool())
    high[:, 2] = np.where(TIME < 5.0, lift(), 0.22)
    box = with_hand()
    assert len(found(box, starts=(0.0, 5.0))) == 1
    assert found(box, starts=(0.0, 5.0))[0].end < 5.05


def test_a_short_slip_in_the_hand_is_no_loss():
    path = with_hand()
    path[np.searchsorted(TIME, 3.0) :, 1] += 0.02
    (one,) = found(path)
    assert one.ending == "kept"


def test_a_hand_that_holds_nothing_is_empty_from_its_lift_on():
    recording = synthetic(success=False, frames=300, duration=10.0)
    recording = replace(recording, meta={**recording.meta, "outcomes": synthetic().meta["outcomes"]})
    full = synthetic()
    lifted = replace(full, meta={**full.meta, "success": False, "grasped": 0, "reason": "nothing"})
    (moment,) = emptied(lifted, (), [(0.0, 10.0)])
    # The lift begins at 7.6 s and rises by 20 cm from 7.8 to 10 s.
    assert 8.0 < moment < 9.0
    loss = found(with_hand(until=3.3))
    assert emptied(lifted, loss, [(0.0, 10.0), (3.4, 10.0)]) == [loss[0].end, moment]
    assert emptied(recording, (), [(0.0, 6.4)]) == [None]


def test_a_recording_tells_what_the_hand_carried():
    assert [(one.object, one.ending) for one in carried_in(synthetic())] == [
        ("light_sphere_00", "kept"),
        ("light_sphere_01", "kept"),
    ]
    assert carried_in(synthetic(success=False)) == ()
    assert carried_in(replace(synthetic(), signals={})) == ()


@pytest.mark.parametrize("meta", [None, "release", [3, {"name": "release"}], [{"name": "release", "start": "now"}]])
def test_odd_outcomes_release_nothing(meta):
    assert releases_in(meta) == []
