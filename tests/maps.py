"""Maps of heights for tests."""

import numpy as np
from scipy import ndimage

import roughcontact as rc


def rough(seed: int, shape: tuple[int, int], holes: float = 0.0) -> np.ndarray:
    """Return normally distributed heights, a share of them missing."""
    rng = np.random.default_rng(seed)
    heights = rng.standard_normal(shape)
    heights[rng.random(shape) < holes] = np.nan
    return heights


def gaussian_map(
    shape: tuple[int, int], correlation: tuple[float, float], seed: int = 0
) -> np.ndarray:
    """Return a periodic Gaussian map with the correlation exp(-y²/4a² - x²/4b²) in pixels."""
    noise = np.random.default_rng(seed).normal(size=shape)
    return ndimage.gaussian_filter(noise, correlation, mode="wrap", truncate=6)


def anisotropic_surface(
    shape: tuple[int, int] = (45, 70), pixel: tuple[float, float] = (0.8e-6, 0.5e-6), seed: int = 0
) -> rc.Surface:
    """Return a rough map with ny ≠ nx and dy ≠ dx."""
    heights = rc.self_affine(
        shape, pixel, rms_height=0.1e-6, rolloff_wavelength=12e-6, cutoff_wavelength=2e-6, rng=seed
    )
    return rc.Surface(heights, pixel)
