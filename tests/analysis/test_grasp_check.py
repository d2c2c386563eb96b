"""What counts as held: an object that has risen and is near the tool."""

import numpy as np

from pilegrasp_ctrl.analysis.grasp_check import REACH, are_held

TOOL_AT = np.array([0.8, 0.0, 0.25])
IN_HAND = TOOL_AT + np.array([0.03, 0.0, 0.02])


def held(*positions, rest=0.027, lift=0.2):
    """Count, among objects at these positions that lay at the height `rest`, those in the hand at `TOOL_AT`."""
    places = np.array(positions, dtype=float).reshape(-1, 3)
    return int(are_held(places, TOOL_AT, np.full(len(places), rest), lift).sum())


def test_an_object_counts_that_has_risen_and_is_near():
    assert held(IN_HAND) == 1
    assert held(IN_HAND, TOOL_AT, [0.8, 0.0, 0.027]) == 2
    assert held() == 0


def test_an_object_elsewhere_does_not_count():
    aside = np.array([0.0, REACH, 0.0])
    assert held(TOOL_AT + 0.99 * aside) == held(TOOL_AT - 0.99 * aside) == 1
    assert held(TOOL_AT + 1.01 * aside) == held(TOOL_AT - 1.01 * aside) == 0
    assert held([0.8, 0.0, 1.5]) == 0


def test_an_object_that_did_not_rise_does_not_count():
    assert held(IN_HAND, rest=IN_HAND[2] - 0.11) == 1
    assert held(IN_HAND, rest=IN_HAND[2] - 0.09) == 0
    assert held(IN_HAND, rest=IN_HAND[2] - 0.09, lift=0.1) == 1
