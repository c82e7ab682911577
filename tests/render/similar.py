"""How alike two pictures are (Wang et al. 2004), and how colours look to a colour-blind reader."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter

# Machado, Oliveira & Fernandes (2009), severity 1: linear RGB to linear RGB
BLIND = {
    "protanopia": [
        [0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
}  # fmt: skip
TO_XYZ = np.array([
    [0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
    [0.0193339, 0.1191920, 0.9503041],
])  # fmt: skip
WHITE = TO_XYZ.sum(axis=1)


def similarity(one: np.ndarray, other: np.ndarray) -> float:
    """Mean structural similarity of two pictures (height, width, 3) of 0 to 255, of their grey."""
    a, b = (np.asarray(image, dtype=float)[..., :3].mean(axis=2) for image in (one, other))

    def mean(x: np.ndarray) -> np.ndarray:
        return gaussian_filter(x, 1.5, truncate=3.5)

    low, high = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    ma, mb = mean(a), mean(b)
    va, vb, cov = mean(a * a) - ma * ma, mean(b * b) - mb * mb, mean(a * b) - ma * mb
    index = (2 * ma * mb + low) * (2 * cov + high) / ((ma**2 + mb**2 + low) * (va + vb + high))
    return float(index.mean())


def lab(colour, sight: str | None = None) -> np.ndarray:
    """A colour of sRGB in CIELAB (D65), as a reader with this sight sees it."""
    value = np.asarray(colour, dtype=float)
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    if sight is not None:
        linear = np.clip(np.array(BLIND[sight]) @ linear, 0.0, 1.0)
    t = TO_XYZ @ linear / WHITE
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def distance(one, other, sight: str | None = None) -> float:
    """Difference of two colours in CIELAB (CIE 1976); 2.3 is just noticeable."""
    return float(np.linalg.norm(lab(one, sight) - lab(other, sight)))
