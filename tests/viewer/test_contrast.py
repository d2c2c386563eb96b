"""Texts and lines stand out from what is behind them, in the light and in the dark scheme (WCAG 2.2: 1.4.3, 1.4.11)."""

from __future__ import annotations

import re

import numpy as np
import pytest

from colours import contrast
from pilegrasp_ctrl.viewer.templates import trusted

BAND_OPACITY = 0.62
"""Opacity of a primitive's band behind the curves."""

STYLE = str(trusted("page/page.css"))
SCHEMES = dict(zip(("light", "dark"), re.findall(r":root \{(.*?)\}", STYLE, flags=re.DOTALL), strict=True))


@pytest.fixture(params=SCHEMES)
def colors(request):
    """The variables of a colour scheme, as (3,) arrays in 0..255."""
    found = re.findall(r"--(\w+): #([0-9a-f]{6})", SCHEMES[request.param])
    return {name: np.array([int(code[k : k + 2], 16) for k in (0, 2, 4)], dtype=float) for name, code in found}


def bands(colors):
    return [colors[f"p{k}"] for k in range(6)]


def behind_curves(colors):
    paper = colors["paper"]
    return [paper, *(BAND_OPACITY * band + (1 - BAND_OPACITY) * paper for band in bands(colors))]


def test_texts_have_a_contrast_of_four_and_a_half(colors):
    assert f"opacity: {BAND_OPACITY}" in STYLE
    for text in ("ink", "soft", "bad", "good", *(f"j{k}" for k in range(7)), "line0", "line1", "line2"):
        assert contrast(colors[text], colors["paper"]) >= 4.5, text
    for text in ("ink", "soft", "bad"):
        assert contrast(colors[text], colors["ground"]) >= 4.5, text
    for band in bands(colors):
        assert contrast(colors["ink"], band) >= 4.5
        assert contrast(colors["bad"], band) >= 4.5


def test_curves_and_marks_have_a_contrast_of_three(colors):
    for ground in behind_curves(colors):
        for line in ("line0", "line1", "line2", "bad", "cursor", *(f"j{k}" for k in range(7))):
            assert contrast(colors[line], ground) >= 3.0, line


def test_names_on_the_bars_of_the_hand_can_be_read(colors):
    for bar in ("kept", "released", "lost"):
        assert contrast(colors["bar"], colors[bar]) >= 4.5, bar


def test_borders_of_controls_can_be_seen(colors):
    assert contrast(colors["edge"], colors["paper"]) >= 3.0
