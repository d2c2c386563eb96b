"""How far colours are apart for normal sight and three kinds of colour blindness: CIEDE2000, and Machado's matrices."""

from __future__ import annotations

import numpy as np

SIGHTS = {
    "normal": np.eye(3),
    # Machado, Oliveira and Fernandes, IEEE TVCG 15 (2009), severity 1.0, on linear RGB.
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
"""Matrix (3, 3) on linear RGB of each kind of sight."""

_TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
_WHITE = np.array([0.95047, 1.0, 1.08883])


def linear(rgb: np.ndarray) -> np.ndarray:
    """Return linear light of sRGB values in 0..255."""
    share = np.asarray(rgb, dtype=float) / 255.0
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def lab(rgb: np.ndarray, sight: str = "normal") -> np.ndarray:
    """Return CIELAB (..., 3) of sRGB values in 0..255 as a kind of sight sees them."""
    seen = np.clip(linear(rgb) @ SIGHTS[sight].T, 0.0, 1.0)
    ratio = seen @ _TO_XYZ.T / _WHITE
    f = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return np.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], axis=-1)


def difference(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Return CIEDE2000 between CIELAB colours (Sharma, Wu and Dalal, Color Res. Appl. 30, 2005)."""
    (l1, a1, b1), (l2, a2, b2) = np.moveaxis(np.asarray(one), -1, 0), np.moveaxis(np.asarray(two), -1, 0)
    mean = 0.5 * (np.hypot(a1, b1) + np.hypot(a2, b2))
    g = 0.5 * (1 - np.sqrt(mean**7 / (mean**7 + 25.0**7)))
    a1, a2 = a1 * (1 + g), a2 * (1 + g)
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.arctan2(b1, a1) % (2 * np.pi), np.arctan2(b2, a2) % (2 * np.pi)
    turn = (h2 - h1 + np.pi) % (2 * np.pi) - np.pi
    turn = np.where(c1 * c2 == 0, 0.0, turn)
    h = np.where(c1 * c2 == 0, h1 + h2, h1 + 0.5 * turn)
    light, chroma = 0.5 * (l1 + l2), 0.5 * (c1 + c2)
    t = 1 - 0.17 * np.cos(h - np.pi / 6) + 0.24 * np.cos(2 * h) + 0.32 * np.cos(3 * h + np.deg2rad(6))
    t = t - 0.20 * np.cos(4 * h - np.deg2rad(63))
    sl = 1 + 0.015 * (light - 50) ** 2 / np.sqrt(20 + (light - 50) ** 2)
    sc, sh = 1 + 0.045 * chroma, 1 + 0.015 * chroma * t
    rotation = -2 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
    degrees = np.rad2deg(h) % 360
    rotation = rotation * np.sin(np.deg2rad(60 * np.exp(-(((degrees - 275) / 25) ** 2))))
    dl, dc, dh = (l2 - l1) / sl, (c2 - c1) / sc, 2 * np.sqrt(c1 * c2) * np.sin(turn / 2) / sh
    return np.sqrt(dl**2 + dc**2 + dh**2 + rotation * dc * dh)


def contrast(one: np.ndarray, two: np.ndarray) -> float:
    """Return the contrast ratio of two sRGB colours by the Web Content Accessibility Guidelines, 1 to 21."""
    light, dark = sorted((float(linear(colour) @ _TO_XYZ[1]) for colour in (one, two)), reverse=True)
    return (light + 0.05) / (dark + 0.05)
