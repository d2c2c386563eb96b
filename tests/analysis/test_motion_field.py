"""The field of mean motion around the hand, and the funnel in it."""

import numpy as np
import pytest

from pilegrasp_ctrl.analysis.motion import measure
from pilegrasp_ctrl.analysis.motion_field import X_EDGES, Y_EDGES, Funnel, MotionField
from pilegrasp_ctrl.analysis.push_motion import PushMotion
from pushed_pile import (
    BEGIN,
    END,
    HALF_WIDTH,
    RADIUS,
    SPEED,
    crowd,
    moving,
    push_recording,
)


def test_a_field_holds_the_motion_in_each_cell_and_fields_add_up():
    push = PushMotion.of(push_recording({"a": moving(0.05, 0.0, SPEED, 0.0), "b": moving(0.05, 0.1, SPEED, 0.02)}))
    field = MotionField.of(push)
    cell = np.searchsorted(X_EDGES, 0.05) - 1, np.searchsorted(Y_EDGES, 0.0) - 1
    assert field.mean_absolute()[cell] == pytest.approx([SPEED, 0.0], abs=1e-6)
    assert field.mean_relative()[cell] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert field.time.sum() == pytest.approx(2 * (END - BEGIN))
    assert field.count.sum() == 2 * (push.time.size - 1)
    assert np.isnan(field.mean_absolute()[0, 0]).all()
    both = field + field
    assert both.attempts == 2
    assert both.half_width == pytest.approx(HALF_WIDTH)
    assert np.array_equal(both.count, 2 * field.count)
    assert both.mean_relative()[cell] == pytest.approx(field.mean_relative()[cell])


def test_a_pile_at_rest_flows_into_the_hand_over_its_own_width():
    assert measure(push_recording(crowd(0.0)))["funnel_width"] == pytest.approx(2 * HALF_WIDTH, rel=0.02)


@pytest.mark.parametrize("slope", [0.3, -0.3])
def test_diverging_objects_narrow_the_funnel_and_converging_objects_widen_it(slope):
    # dy/dx = u_y / u_x = -slope y / SPEED: stream lines are exponentials; y itself grows meanwhile, by the factor g.
    field = MotionField.of(PushMotion.of(push_recording(crowd(0.0, slope))))
    width = Funnel.of(field).width_at(4 * RADIUS)
    assert (width - 2 * HALF_WIDTH) * slope < 0.0
    steeper = Funnel.of(MotionField.of(PushMotion.of(push_recording(crowd(0.0, 2 * slope))))).width_at(4 * RADIUS)
    assert (steeper - width) * slope < 0.0
    assert Funnel.of(field).width_at(0.0) == pytest.approx(2 * HALF_WIDTH)


def test_a_pile_that_moves_with_the_hand_has_no_funnel():
    found = measure(push_recording(crowd(SPEED)))
    assert found["funnel_width"] is None
    assert found["mouth_width"] == pytest.approx(2 * HALF_WIDTH)
