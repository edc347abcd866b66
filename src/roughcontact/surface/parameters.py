"""All roughness parameters of ISO 25178-2 at once.

The standard's parameters belong to a scale-limited surface, without form and filtered. Nothing is
leveled or filtered here: level the map first. Only its mean is subtracted, which the standard
takes to be zero. Missing points (NaN) are left out of every average. Material ratios and Sdr are
fractions, not per cent.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import require_pixel
from roughcontact.surface.bearing import core_parameters, material_ratio_curve, volume_parameters
from roughcontact.surface.roughness import developed_area_ratio, height_parameters, rms_gradient
from roughcontact.surface.spectrum import texture

Array = NDArray[np.float64]


def summary(heights: Array, pixel: tuple[float, float]) -> dict[str, float]:
    """Return the parameters of ISO 25178-2, under the standard's symbols and in SI units.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights [m], leveled and, if wanted, filtered before; NaN where missing.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Returns
    -------
    dict
        ``Sq, Sa, Sp, Sv, Sz`` [m], ``Ssk, Sku`` (`height_parameters`); ``Sdq`` (`rms_gradient`),
        ``Sdr`` (`developed_area_ratio`); ``Sal`` [m], ``Str`` and its upper bound ``Str_max``
        (`spectrum.texture`);
        ``Sk, Spk, Svk`` [m], ``Smr1, Smr2`` (`core_parameters`); ``Vmp, Vmc, Vvc, Vvv``
        [m³/m²] (`volume_parameters`).

        Ssk, Sku, Sal and Str of a flat map are NaN. Sal and Str are NaN too if the
        correlation decays in no direction on this map. Str alone is NaN if it decays in some
        directions but not in all within half the map: it is then not determined, and known to be
        at most ``Str_max``.

    Raises
    ------
    InputError
        If the pixel is not positive, or if no point, no slope or no cell of four is there.

    References
    ----------
    ISO 25178-2:2021, sections 4.2 to 4.5

    Examples
    --------
    >>> wave = np.cos(2 * np.pi * np.arange(64) / 16) * np.ones((64, 1))
    >>> values = summary(wave, (1.0, 1.0))
    >>> round(values["Sq"], 6), round(values["Sku"], 6), values["Str"]
    (0.707107, 1.5, nan)
    """
    require_pixel(pixel)
    sal, ratio, largest = texture(heights, pixel)
    curve = material_ratio_curve(heights)
    return {
        **height_parameters(heights),
        "Sdq": rms_gradient(heights, pixel),
        "Sdr": developed_area_ratio(heights, pixel),
        "Sal": sal,
        "Str": ratio,
        "Str_max": largest,
        **core_parameters(*curve),
        **volume_parameters(*curve),
    }
