"""Reconstruction of the surface behind a measured map: its spectrum, and random draws.

`Reconstruction.draw`: pathwise conditioning. With the map y, its instrument M and a random surface
ζ of the fitted spectrum, ``d = R(y) + ζ - R(M(ζ))`` is a draw of the surface, where R undoes the
transfer. For a linear M and the best R it is an exact draw of the Gaussian posterior; else the
error of R is transferred from ζ to y. It must not depend on the place: a residual valley of ζ on a
summit of y lowers the summit.

Wilson et al. 2021, arXiv:2011.04026

R: ``H = C T/(C T² + N)`` with the spectrum C, the transfer T and the noise N. Waves beyond q_r of a
map, and of M(ζ), first get the power that the model predicts for their length: an inaccurate
transfer would amplify them without limit, as well as the rims of filled points and the step between
the edges of a leveled map.

A tip dilates the surface before the map is averaged over pixels, so R undoes the average first,
with C of the image of the tip, and erodes afterwards. Erosion is exact where the tip touched, and
too high elsewhere: where a tip of twice the radius fills R. The error of R has there the mean and
the standard deviation that it has on ζ, by classes of the height filled. The mean is subtracted.
Missing points do not limit the erosion of measured ones: filled across a steep flank, they are
lower than the tip was, and would cut off the next summit. Erosion has edges where the tip left
the surface, which has none: waves down to the shortest one of the surface are fitted to it, with
the inverse variance of the error as weight. The mean error that is left on summits and slopes, by
classes of the curvature, is subtracted. ``ζ - R(M(ζ))`` is reduced to the standard deviation of its
place on y: a valley of ζ that the tip did not reach does not lower a summit of y that it touched.

Villarrubia 1997, doi:10.6028/jres.102.030

Worn surfaces have weaker short waves on summits: ``d = R(y) + m (ζ - R(M(ζ)))``, where m is the
roughness of the map in the shortest octave at the height of R(y), over that of maps of random
surfaces. R needs no m: it undoes the transfer of the waves that the map shows.

Spectrum: power less noise over T², in fifths of an octave of the wave number q, times the lay:
the mean power of an octave in one of 24 directions over its mean power. It is evaluated up to
q_r, where T is one half or noise is half of the power. From there to the shortest wave of the
surface, the spectrum is a power law with its exponent between roll-off and q_r, and the prior of
a Hurst exponent of 0.8 ± 0.4. The more a transfer bends the spectrum up, the less plausible is
the transfer.

Finer maps of the surface add their spectra, each up to its q_r. A bin is the mean of the maps,
each weighted by one over the variance of its logarithm: one over the number of its waves, plus
``(2 u d ln T/d ln λ50)²`` for a resolution with the relative uncertainty u.

Jacobs, Junge & Pastewka 2017, doi:10.1088/2051-672X/aa51f8

A leveled map of a periodic surface gets the plane back that closes its edges. A map that is not
periodic is split into a periodic and a smooth part.

Moisan 2011, doi:10.1007/s10851-010-0227-1
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse.linalg import LinearOperator, cg

from roughcontact.errors import InputError
from roughcontact.halfspace import fft
from roughcontact.surface import filters
from roughcontact.surface.cleaning import fill_missing
from roughcontact.surface.form import level
from roughcontact.surface.instrument import Instrument, dilate
from roughcontact.surface.random_surfaces import random_amplitudes

Array = NDArray[np.float64]
Deviations = Mapping[str, float]
"""Standard normal deviations of uncertain parameters, by name; 0 by default."""

# Number of bins of the spectrum per octave.
_BINS = 5
# Exponent of the spectrum: prior of H = 0.8 ± 0.4 and range; spread of the level.
_EXPONENT, _SPREAD, _STEEPEST, _FLATTEST, _LEVEL = -3.6, 0.8, -4.4, -1.8, 0.25
# Standard deviation of the logarithm of a bin about a power law.
_SCATTER = 0.15
UNKNOWN = 4.0
"""Maximum ratio of resolution and shortest wave of a surface, if no wave is given."""
# Smallest transfer that is inverted.
_MIN_TRANSFER = 0.1
# Power of a single wave over the mean of its surroundings; share of marks and skewness above which
# summits are not worn.
_SINGLE, _MARKED, _WORN = 8.0, 0.1, -0.3
# Number of directions of the lay.
_DIRECTIONS = 24
# Number of height classes; relative reduction of roughness from which the highest sixteenth is
# worn; standard deviation of the median of one wave over its root-mean-square; median of the
# magnitude of random heights.
_CLASSES, _UNEVEN, _CHANCE, _MEDIAN = 96, 0.25, 0.83, 0.6745
# Smallest roughness of a height class over that of random surfaces.
_SMOOTHEST = 0.02
# Number of twins whose maps give the roughness of summits of unworn surfaces.
_TWINS = 3
# Largest difference of the logarithms of two spectra of one surface in their common octave, beyond
# the random scatter.
_SPECTRUM_TOLERANCE = 0.7
# Maximum step between opposite edges of a periodic map, over the step between neighbors.
_SEAM = 2.0
# Weights of the steps next to a seam in its expected step: cubic interpolation.
_SEAM_WEIGHTS = np.array([-1, 4, 0, 4, -1]) / 6
# Number of iterations in which the image of a surface under a tip gets the spectrum of the map.
_ROUNDS = 3
# Number of iterations that fit waves to weighted heights.
_FITS = 10


@dataclass(frozen=True, eq=False)
class Lay:
    """Power of waves in each direction over the mean power of all directions."""

    place: Array  # Logarithm of the wave number of each bin [1/m]
    ratio: Array  # Ratio per bin and direction

    def ratio_at(self, qy: Array, qx: Array) -> Array:
        """Return the ratio of waves; beyond the last bin, that of the last bin."""
        row = np.interp(np.log(np.hypot(qy, qx) + 1e-300), self.place, np.arange(self.place.size))
        column = _directions(qy, qx)
        # Direction 0 follows the last.
        periodic = np.pad(self.ratio, ((0, 0), (1, 1)), "wrap")
        row, after = row.astype(int), (column + 0.5) % 1
        left = np.floor(column + 0.5).astype(int)
        return np.asarray(periodic[row, left] * (1 - after) + periodic[row, left + 1] * after)


@dataclass(frozen=True, eq=False)
class RoughSpectrum:
    """Power spectrum of a surface in bins of the wave number, with a power law beyond."""

    lay: Lay
    place: Array  # Logarithm of the wave number of each bin [1/m]
    power: Array  # Logarithm of the power of one wave of each bin [m²]
    limit: float  # Wave number of the last bin [1/m]
    exponent: float  # Exponent of the power law
    level: float  # Logarithm of the power at the limit [m²]
    cutoff: float  # Largest wave number [1/m]

    def power_at(self, shape: tuple[int, ...], pixel: tuple[float, float]) -> Array:
        """Return the power of the waves of a grid [m²]."""
        qy, qx = _waves(shape, pixel)
        q = np.hypot(qy, qx)
        logarithm = np.log(np.maximum(q, np.exp(self.place[0])))
        beyond = self.level + self.exponent * (logarithm - math.log(self.limit))
        inside = np.interp(logarithm, self.place, self.power)
        power = np.exp(np.where(logarithm <= math.log(self.limit), inside, beyond))
        power[q > self.cutoff * (1 + 1e-9)] = 0.0
        power[0, 0] = 0.0
        return np.asarray(power * self.lay.ratio_at(qy, qx))


@dataclass(frozen=True, eq=False)
class _ErrorClasses:
    """Mean and standard deviation of errors of heights, by classes of a quantity."""

    place: Array  # Mean quantity of each class
    mean: Array  # Mean error less that of the first class [m]
    spread: Array  # Standard deviation [m]

    @classmethod
    def from_errors(cls, values: Array, error: Array) -> _ErrorClasses:
        """Return the errors in classes of equal size."""
        values, error = values.ravel(), error.ravel()
        parts = np.array_split(values.argsort(), _CLASSES)
        place, mean, spread = (
            np.array([function(known[part]) for part in parts])
            for known, function in ((values, np.mean), (error, np.mean), (error, np.std))
        )
        # Equal values, as those of points that the tip touched, are one class.
        first = place <= place[0] + 1e-6 * (place[-1] - place[0])
        mean[first], spread[first] = mean[first].mean(), spread[first].mean()
        return cls(place, mean - mean[0], spread)

    def interpolate(self, filled: Array) -> tuple[Array, Array]:
        """Return mean and standard deviation of the errors where a tip fills a height.

        They begin as the square of the height filled, and continue so beyond the last class.
        """
        # Rounding fills no valley.
        deepest = self.place[-1] + 1e-9 * filled.std() + 1e-300
        deeper = np.maximum(filled / deepest, 1.0) ** 2
        mean, spread = (
            np.interp(filled, self.place, part) * deeper for part in (self.mean, self.spread)
        )
        return mean, spread


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """Measured map, its instrument, and the shortest wave of its surface."""

    heights: Array  # Periodic part of the filled map [m]
    pixel: tuple[float, float]  # Pixel edges [m]
    instrument: Instrument
    shortest_wave: float | None = None  # Shortest wave of the surface [m]
    missing: NDArray[np.bool_] | None = None  # Filled points
    form: str | None = None  # Form removed by leveling
    finer: int = 2  # Points of the surface per point of the map along an axis
    is_closed: bool = False  # Whether the plane is restored that leveling took from a periodic map
    others: tuple[Reconstruction, ...] = ()  # Finer maps of the surface
    wear: tuple[Array, Array] | None = None  # Heights [m], and their share of short waves

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points of the surface."""
        ny, nx = self.heights.shape
        return ny * self.finer, nx * self.finer

    @property
    def fine(self) -> tuple[float, float]:
        """Pixel edges of the surface [m]."""
        return self.pixel[0] / self.finer, self.pixel[1] / self.finer

    @property
    def noise(self) -> float:
        """Noise in the power of one wave [m²]."""
        return self._noise(self.instrument)

    @cached_property
    def power(self) -> Array:
        """Power of the waves of the map [m²]."""
        return _power(self.heights)

    @cached_property
    def limit(self) -> float:
        """Wave number up to which the map resolves its surface [1/m]."""
        nyquist = 0.5 / max(self.pixel)
        q = np.linspace(0.0, nyquist, 400)[1:]
        half = self.instrument.lateral_transfer(q) * np.sinc(q * max(self.pixel))
        limit = float(q[half >= 0.5][-1])
        if self.noise:
            place, power = _bin_power(self._wave_numbers, self.power, nyquist)
            noisy = np.exp(place[power < 2 * self.noise])
            limit = min([limit, *noisy])
        return limit

    @property
    def reach(self) -> float:
        """Wave number up to which any of the maps resolves the surface [1/m]."""
        return max([self.limit, *(other.limit for other in self.others)])

    @cached_property
    def _clean_power(self) -> Array:
        """Power of the waves of the surface, where the map resolves it [m²]."""
        clean = np.maximum(self.power - self.noise, 0.0) / self._power_transfer(self.instrument)
        return np.asarray(clean)

    @cached_property
    def lay(self) -> Lay:
        """Lay of the surface up to the limit."""
        qy, qx = _waves(self.heights.shape, self.pixel)
        q, clean = self._wave_numbers, self._clean_power
        place, power = _bin_power(q, clean, self.limit)
        index = np.searchsorted((place[1:] + place[:-1]) / 2, np.log(np.maximum(q, 1e-300)))
        column = np.floor(_directions(qy, qx)).astype(int) % _DIRECTIONS
        weight = np.where((q > 0) & (q <= self.limit), 2.0, 0.0)
        weight[:, 0] /= 2
        cell = (index * _DIRECTIONS + column).ravel()
        sums = [
            np.bincount(cell, values.ravel(), place.size * _DIRECTIONS).reshape(place.size, -1)
            for values in (weight, weight * clean / np.maximum(power, 1e-300)[index])
        ]
        # Sums over an octave and over neighboring directions, so that each contains many waves.
        count, total = (
            ndimage.convolve1d(
                ndimage.convolve1d(part, np.ones(_BINS), 0, mode="constant"),
                np.array([0.25, 0.5, 0.25]),
                1,
                mode="wrap",
            )
            for part in sums
        )
        return Lay(place, (total + 1) / (count + 1))

    @cached_property
    def marks(self) -> float:
        """Share of the squared slope in single waves that stand out: marks of a tool, grooves.

        The power of one wave of a random surface is distributed exponentially about the mean of
        its surroundings: one in 3000 exceeds it eightfold.
        """
        qy, qx = _waves(self.heights.shape, self.pixel)
        q, clean = self._wave_numbers, self._clean_power
        place, power = _bin_power(q, clean, self.limit)
        mean = np.exp(np.interp(np.log(np.maximum(q, 1e-300)), place, np.log(power)))
        weight = np.where((q > 0) & (q <= self.limit), q**2 * clean, 0.0)
        weight[:, 1:] *= 2
        single = clean > _SINGLE * mean * self.lay.ratio_at(qy, qx)
        return float(weight[single].sum() / weight.sum())

    @property
    def has_rolloff(self) -> bool:
        """Whether the longest waves are not much higher than waves of half their length."""
        longest = 1 / min(_sides(self))
        place, power = _bin_power(self._wave_numbers, self.power, 4.4 * longest)
        longer = place < math.log(2.2 * longest)
        rise = np.log(power[longer]).mean() - np.log(power[~longer]).mean()
        return bool(rise < -_EXPONENT * math.log(2) / 2)

    @cached_property
    def resolution(self) -> tuple[float, float]:
        """Mean and spread of the logarithm of resolution over given value, from the spectrum."""
        tool = self.instrument
        if not tool.resolution * tool.u_resolution:
            return 0.0, 0.0
        place, power = self._bins(tool)
        rise = _resolution_sensitivity(place, tool)
        known, covariance = self._power_law(place, power, self._count(place), rise)
        # A spectrum that bends down may be real; one that bends up was sharpened too much.
        mean = min(float(known[2]), 0.0)
        return tool.u_resolution * mean, tool.u_resolution * math.sqrt(covariance[2, 2])

    def drawn_instrument(self, deviations: Deviations) -> Instrument:
        """Return the instrument with its lengths changed by standard deviations."""
        mean, spread = self.resolution
        tool = self.instrument
        return tool.vary(
            resolution=math.exp(mean + spread * deviations.get("resolution", 0.0)),
            tip_radius=math.exp(tool.u_tip_radius * deviations.get("tip", 0.0)),
            noise=math.exp(tool.u_noise * deviations.get("noise", 0.0)),
            shape=tool.u_shape * deviations.get("shape", 0.0),
        )

    def spectrum(self, instrument: Instrument, deviations: Deviations, seed: int) -> RoughSpectrum:
        """Return the spectrum of the surface for one instrument."""
        place, power = self._bins(instrument)
        cutoff, finer = 1 / self._shortest(deviations), self._finer(deviations, seed)
        result = self._continue_spectrum(place, power, finer, cutoff, deviations)
        # The simulated image of a synthetic surface must have the power of the map.
        for _ in range(_ROUNDS if instrument.tip_radius else 1):
            model = self.surface(result, seed, even=True)
            image = self.image(model, instrument, np.random.default_rng(seed))
            _, got = _bin_power(self._wave_numbers, _power(image), self.limit)
            _, wanted = _bin_power(self._wave_numbers, self.power, self.limit)
            noise = self._noise(instrument)
            ratio = np.maximum(wanted - noise, 0.1 * wanted) / np.maximum(got - noise, 0.1 * got)
            power = power + np.log(np.clip(ratio, 0.3, 3))
            result = self._continue_spectrum(place, power, finer, cutoff, deviations)
        return result

    def surface(self, spectrum: RoughSpectrum, seed: int, even: bool = False) -> Array:
        """Return a random surface with a spectrum; ``even``: each wave has its mean power."""
        waves = random_amplitudes(self.shape, self.fine, np.random.default_rng(seed))
        if even:
            size = np.abs(waves)
            waves *= math.sqrt(2) / np.where(size > 0, size, 1.0)
        waves *= np.sqrt(spectrum.power_at(self.shape, self.fine) / 2) * math.prod(self.shape)
        return fft.irfft2(waves, self.shape)

    def image(self, surface: Array, instrument: Instrument, rng: np.random.Generator) -> Array:
        """Return the simulated map of a surface: measured, filled, leveled and split."""
        image = instrument.image(surface, self.fine, self.heights.shape)
        image = image + instrument.noise * rng.standard_normal(image.shape)
        if self.missing is not None and self.missing.any():
            image[self.missing] = np.nan
            image = fill_missing(image, self.pixel)
        if self.form is None or self.is_closed:
            return image
        # Leveling causes a step between opposite edges.
        return periodic_part(level(image, self.form))

    def invert_image(self, image: Array, spectrum: RoughSpectrum, instrument: Instrument) -> Array:
        """Return a surface whose simulated map approximates an image."""
        transfer = self._transfer(instrument)
        if instrument.tip_radius:
            power = self._dilated_power(instrument)
        else:
            power = spectrum.power_at(self.heights.shape, self.pixel)
            image = self._shape_waves(image, spectrum, instrument)
        below = power * transfer**2 + self._noise(instrument)
        # The inverse of a smaller transfer amplifies its own error.
        seen = (below > 0) & (transfer > _MIN_TRANSFER)
        undo = np.divide(power * transfer, below, out=np.zeros_like(power), where=seen)
        undo[0, 0] = 1.0
        heights = fft.irfft2(fft.rfft2(image) * undo, self.heights.shape)
        heights = filters.resample(heights, self.shape)
        if not instrument.tip_radius:
            return heights
        return self._erode(heights, instrument.tip_radius)

    @cached_property
    def _fine_missing(self) -> NDArray[np.bool_]:
        """Whether points of the surface belong to filled points of the map."""
        if self.missing is None:
            return np.zeros(self.shape, dtype=bool)
        return np.kron(self.missing, np.ones((self.finer, self.finer), dtype=bool))

    @property
    def hidden_depth(self) -> Array:
        """Depth of the valleys of filled points, if the slope of their edges continues [m]."""
        if self.missing is None or not self.missing.any():
            return np.zeros(self.shape)
        slope = np.hypot(*np.gradient(self.heights, *self.pixel))
        edge = ndimage.binary_dilation(self.missing) & ~self.missing
        distance = ndimage.distance_transform_edt(self._fine_missing, sampling=self.fine)
        return np.asarray(slope[edge].mean() * distance)

    def _erode(self, heights: Array, tip_radius: float) -> Array:
        """Return the highest surface below a map; filled points do not limit measured ones."""
        eroded = -dilate(-heights, self.fine, tip_radius)
        if self._fine_missing.any():
            limits = np.where(self._fine_missing, heights.max(), heights)
            limited = -dilate(-limits, self.fine, tip_radius)
            eroded = np.where(self._fine_missing, eroded, limited)
        return eroded

    def draw(self, deviations: Deviations, seed: int) -> tuple[Array, Array, Array]:
        """Return a draw of the surface, a random surface, and its simulated map.

        A worn surface has other heights than random ones: the map is that of the draw.
        """
        twin, image, estimate = self.simulate(deviations, seed)
        (drawn, spread), (known, own) = estimate(self.heights), estimate(image)
        rest = (twin - known) * np.minimum(spread / np.maximum(own, 1e-300), 1.0)
        if self.wear is None:
            return drawn + rest, twin, image
        heights, share = self.wear
        summits = np.log(share[-_CLASSES // 16 :]).mean()
        power = 1 + deviations.get("summits", 0.0) * self._summits[1] / summits
        drawn = drawn + rest * np.interp(drawn, heights, share**power)
        instrument = self.drawn_instrument(deviations)
        return drawn, twin, self.image(drawn, instrument, np.random.default_rng([seed, 1]))

    def simulate(
        self, deviations: Deviations, seed: int
    ) -> tuple[Array, Array, Callable[[Array], tuple[Array, Array]]]:
        """Return a random surface, its simulated map, and R with the spread of its error."""
        instrument = self.drawn_instrument(deviations)
        spectrum = self.spectrum(instrument, deviations, seed)
        twin = self.surface(spectrum, seed)
        image = self.image(twin, instrument, np.random.default_rng([seed, 1]))
        invert = partial(self.invert_image, spectrum=spectrum, instrument=instrument)
        even, radius = np.ones(self.shape), 2 * instrument.tip_radius
        if not radius:
            return twin, image, lambda part: (invert(part), even)

        def touch(part: Array) -> tuple[Array, Array]:
            eroded = invert(part)
            return eroded, self._fill(eroded, radius)

        def smooth(eroded: Array, filled: Array) -> tuple[Array, Array]:
            mean, spread = depths.interpolate(filled)
            # Filled points are as uncertain as the deepest valleys.
            spread[self._fine_missing] = depths.spread[-1]
            weight = (depths.spread[0] / np.maximum(spread, depths.spread[0])) ** 2
            heights = self._fit_waves(eroded + mean, weight, spectrum.cutoff)
            # Minus the Laplacian of the surface, positive on summits.
            q = 2 * math.pi * np.hypot(*_waves(self.shape, self.fine))
            return heights, weight * fft.irfft2(fft.rfft2(heights) * q**2, self.shape)

        def sharpen(heights: Array, curvature: Array) -> Array:
            return np.asarray(heights + np.interp(curvature, bends.place, bends.mean))

        touched = touch(image)
        depths = _ErrorClasses.from_errors(touched[1], twin - touched[0])
        smoothed = smooth(*touched)
        bends = _ErrorClasses.from_errors(smoothed[1], twin - smoothed[0])
        rest = _ErrorClasses.from_errors(touched[1], twin - sharpen(*smoothed))

        def estimate(part: Array) -> tuple[Array, Array]:
            eroded, filled = touched if part is image else touch(part)
            known = smoothed if part is image else smooth(eroded, filled)
            return sharpen(*known), rest.interpolate(filled)[1]

        return twin, image, estimate

    def _fit_waves(self, heights: Array, weight: Array, cutoff: float) -> Array:
        """Return the waves up to a cut-off that fit weighted heights best."""
        keep = np.hypot(*_waves(self.shape, self.fine)) <= cutoff * (1 + 1e-9)

        def limit(values: Array) -> Array:
            return fft.irfft2(fft.rfft2(values.reshape(self.shape)) * keep, self.shape).ravel()

        weight, start = weight.ravel(), limit(heights)
        normal = LinearOperator((start.size,) * 2, lambda step: limit(weight * step))
        rest = limit(weight * (heights.ravel() - start))
        step, _ = cg(normal, rest, rtol=1e-6, maxiter=_FITS)
        return np.asarray(start + step).reshape(self.shape)

    def _fill(self, heights: Array, tip_radius: float) -> Array:
        """Return the height by which a tip fills valleys; zero where it touches a point."""
        closed, steps = heights, []
        for axis, edge in enumerate(self.fine):
            # Further away even the highest point is below a tip that touches the lowest one.
            reach = math.sqrt(2 * tip_radius * float(np.ptp(heights))) / edge
            reach = min(int(reach), (self.shape[axis] - 1) // 2)
            drop = (np.arange(-reach, reach + 1) * edge) ** 2 / (2 * tip_radius)
            tip = np.expand_dims(-drop, 1 - axis)
            closed = ndimage.grey_dilation(closed, structure=tip, mode="wrap")
            steps.append(partial(ndimage.grey_erosion, structure=tip, mode="wrap"))
        for erode in steps:
            closed = erode(closed)
        return np.asarray(closed - heights)

    @property
    def structure(self) -> tuple[float, float]:
        """Skewness of the heights, and kurtosis of their shortest waves, over those of wear."""
        short, _ = self._split_waves(self.heights)
        if self.wear:
            short = short / np.interp(self.heights, *self.wear)
        off = self.heights - self.heights.mean()
        skewness = np.mean(off**3) / np.mean(off**2) ** 1.5
        return float(skewness), float(np.mean(short**4) / np.mean(short**2) ** 2)

    def _split_waves(self, image: Array) -> tuple[Array, Array]:
        """Return the shortest waves of a map, and the longer waves."""
        k = self._wave_numbers * max(1 / self.limit, self.shortest_wave or 0.0)
        # A smooth filter does not mix rough and smooth areas.
        low, waves = np.exp2(-((2 * k) ** 2)), fft.rfft2(image)
        short, long = (
            fft.irfft2(waves * part, image.shape) for part in (np.exp2(-(k**2)) - low, low)
        )
        return short, long

    @property
    def is_worn(self) -> bool:
        """Whether short waves are weaker on summits than elsewhere, beyond random scatter.

        Summits between the marks of a tool are smooth by form; wear skews the heights as well. A
        tip touches summits: no waves of another height are added to them.
        """
        if self.instrument.tip_radius:
            return False
        if self.marks > _MARKED and self.structure[0] > _WORN:
            return False
        rough, chance = np.array([maps._summits for maps in (self, *self.others)]).T
        weight = chance**-2
        least = 1 - max(_UNEVEN, 2 / math.sqrt(weight.sum()))
        return bool(np.average(rough, weights=weight) <= least)

    @property
    def _summits(self) -> tuple[float, float]:
        """Roughness of the summits over that of the map, and the random standard deviation."""
        _, rough = self.relative_roughness
        rough = rough / np.quantile(rough, 0.75)
        top, end = _CLASSES // 16, min(self.limit, 1 / (self.shortest_wave or 1e-300))
        # Relative scatter: one over the square root of the number of waves in these classes.
        waves = 0.75 * math.pi * end**2 * self._area * top / _CLASSES
        return float(rough[-top:].mean()), _CHANCE * math.sqrt((1 + 1 / _TWINS) / waves)

    @cached_property
    def relative_roughness(self) -> tuple[Array, Array]:
        """Mean heights of classes, and their roughness over that of maps of random surfaces."""
        twins = [self._roughness(self.simulate({}, seed)[1])[1] for seed in range(_TWINS)]
        heights, local = self._roughness(self.heights)
        return heights, np.maximum(local / np.mean(twins, axis=0), _SMOOTHEST)

    def _roughness(self, image: Array) -> tuple[Array, Array]:
        """Return mean heights of the classes of a map, and their roughness in short waves."""
        short, long = (part.ravel() for part in self._split_waves(image))
        parts = np.array_split(long.argsort(), _CLASSES)
        # Medians exclude the edges of a worn plateau and the mean curvature from the roughness.
        local = [np.median(np.abs(short[part] - np.median(short[part]))) for part in parts]
        return np.array([long[part].mean() for part in parts]), np.array(local)

    @property
    def hides_summits(self) -> bool:
        """Whether noise may be more than half of the power of short waves on summits."""
        point = np.zeros(self.heights.shape)
        point[0, 0] = _MEDIAN * self.instrument.noise
        noise = np.square(self._split_waves(point)[0]).sum()
        _, local = self._roughness(self.heights)
        return bool(noise > local[-_CLASSES // 16 :].mean() ** 2 / 2)

    def _shape_waves(self, image: Array, spectrum: RoughSpectrum, instrument: Instrument) -> Array:
        """Return a map with the expected power in waves beyond the limit."""
        q = self._wave_numbers
        expected = spectrum.power_at(self.heights.shape, self.pixel)
        expected *= self._transfer(instrument) ** 2
        expected += self._noise(instrument)
        (place, wanted), (_, got) = (
            _bin_power(q, p, float(q.max())) for p in (expected, _power(image))
        )
        beyond = q > self.limit
        factor = np.ones(q.shape)
        factor[beyond] = np.exp(
            np.interp(np.log(q[beyond]), place, np.log(np.maximum(wanted / got, 1e-30)) / 2)
        )
        return fft.irfft2(fft.rfft2(image) * factor, image.shape)

    def _dilated_power(self, instrument: Instrument) -> Array:
        """Return the power of the waves of the image of a tip, before the average over a pixel."""
        clean = (self.power - self._noise(instrument)) / self._power_transfer(instrument)
        q = self._wave_numbers
        place, power = _bin_power(q, clean, float(q.max()))
        mean = np.interp(np.log(np.maximum(q, 1e-300)), place, np.maximum(power, 0.0))
        return np.asarray(mean * self.lay.ratio_at(*_waves(self.heights.shape, self.pixel)))

    def _noise(self, instrument: Instrument) -> float:
        """Return the noise in the power of one wave [m²]."""
        return instrument.noise**2 / self.heights.size

    def _transfer(self, instrument: Instrument) -> Array:
        return instrument.transfer(self.heights.shape, self.pixel, self.pixel)

    def _power_transfer(self, instrument: Instrument) -> Array:
        """Return the square of the transfer, positive for waves that the instrument loses."""
        return np.asarray(np.maximum(self._transfer(instrument), 1e-6) ** 2)

    @cached_property
    def _wave_numbers(self) -> Array:
        """Wave numbers of the map [1/m]."""
        return np.asarray(np.hypot(*_waves(self.heights.shape, self.pixel)))

    def _shortest(self, deviations: Deviations) -> float:
        if self.shortest_wave is not None:
            return self.shortest_wave
        part = NormalDist().cdf(deviations.get("waves", 0.0))
        return float(UNKNOWN**-part / self.reach)

    def _bins(self, instrument: Instrument) -> tuple[Array, Array]:
        """Return the logarithms of wave number and power per bin, corrected for the instrument."""
        noise = self._noise(instrument)
        clean = (self.power - noise) / self._power_transfer(instrument)
        place, power = _bin_power(self._wave_numbers, clean, self.limit)
        _, raw = _bin_power(self._wave_numbers, self.power, self.limit)
        return place, np.log(np.maximum(power, 0.1 * raw))

    @property
    def _area(self) -> float:
        """Number of waves of the map per unit area of the plane of q: its area [m²]."""
        return math.prod(_sides(self))

    def _count(self, place: Array) -> Array:
        """Return the number of waves of the map in bins."""
        return np.asarray(math.pi * math.log(2) / _BINS * self._area * np.exp(2 * place))

    def _finer(self, deviations: Deviations, seed: int) -> list[tuple[Array, Array, Array]]:
        """Return the bins of the finer maps, in the power of this map, with their variances."""
        found = []
        for other in self.others:
            part = {"resolution": deviations.get("finer resolution", 0.0)}
            drawn = other.spectrum(other.drawn_instrument(part), {}, seed)
            # Longer waves represent the measured area rather than the surface.
            inside = drawn.place > math.log(2 / min(_sides(other)))
            size = math.prod(_sides(other)) / math.prod(_sides(self))
            level = math.log1p(_LEVEL) / math.sqrt(len(self.others))
            power = drawn.power + math.log(size) + level * deviations.get("finer level", 0.0)
            variance = (
                1 / other._count(drawn.place)
                + _resolution_sensitivity(drawn.place, other.instrument) ** 2
            )
            found.append((drawn.place[inside], power[inside], variance[inside]))
        return found

    def _continue_spectrum(
        self,
        place: Array,
        power: Array,
        finer: list[tuple[Array, Array, Array]],
        cutoff: float,
        deviations: Deviations,
    ) -> RoughSpectrum:
        count = self._count(place)
        if finer:
            own = place, power, 1 / count + _resolution_sensitivity(place, self.instrument) ** 2
            places, powers, variances = (
                np.concatenate(part) for part in zip(own, *finer, strict=True)
            )
            index = np.floor(_BINS * (math.log(self.reach) - places + 1e-9) / math.log(2))
            sums = [
                np.bincount(index.astype(int), values / variances)[::-1].astype(float)
                for values in (np.ones_like(places), places, powers)
            ]
            count, place, power = (part[sums[0] > 0] for part in sums)
            place, power = place / count, power / count
        (level, exponent), covariance = self._power_law(place, power, count)
        exponent += deviations.get("exponent", 0.0) * math.sqrt(covariance[1, 1])
        exponent = min(max(exponent, _STEEPEST), _FLATTEST)
        level += math.log1p(_LEVEL) * deviations.get("level", 0.0)
        return RoughSpectrum(self.lay, place, power, self.reach, exponent, level, cutoff)

    def _power_law(
        self, place: Array, power: Array, count: Array, *rise: Array
    ) -> tuple[Array, Array]:
        """Return the level at the last bin, exponent and factors of `rise`, with covariance.

        Below the wave number of the roll-off that fits best, the spectrum is flat.
        """
        limit = self.limit if rise else self.reach
        inside = place <= math.log(min(limit, 1 / (self.shortest_wave or 1e-300))) + 1e-9
        x, y = place[inside] - math.log(limit), power[inside]
        scatter = np.sqrt(_SCATTER**2 + 1 / count[inside])
        prior = np.diag([0.0, _SPREAD**-2, *(1.0 for _ in rise)])
        center = np.array([0.0, _EXPONENT, *(0.0 for _ in rise)])
        best, result = math.inf, (center, prior)
        for rolloff in x[: max(x.size - _BINS, 1)]:
            columns = [np.ones(x.size), np.maximum(x, rolloff), *(-part[inside] for part in rise)]
            matrix = np.stack(columns, axis=1) / scatter[:, None]
            covariance = np.linalg.inv(matrix.T @ matrix + prior)
            known = covariance @ (matrix.T @ (y / scatter) + prior @ center)
            error, off = matrix @ known - y / scatter, known - center
            misfit = float(error @ error + off @ prior @ off)
            if misfit < best:
                best, result = misfit, (np.asarray(known), np.asarray(covariance))
        return result


def close_edges(heights: Array) -> Array:
    """Return a leveled map of a periodic surface with the plane that leveling removed.

    The mean step between opposite edges is that of a cubic through the rows next to them.
    """
    for axis in (0, 1):
        along = np.moveaxis(heights, axis, 0)
        steps = np.diff(np.roll(along, 3, 0)[:6], axis=0).mean(axis=1)
        excess = steps[2] - (_SEAM_WEIGHTS * steps).sum()
        ramp = excess * np.linspace(-0.5, 0.5, len(along), endpoint=False)
        heights = np.moveaxis(along + ramp[:, None], 0, axis)
    return heights


def has_seam(heights: Array) -> bool:
    """Return whether a map has a step between opposite edges."""
    steps = [
        np.square(np.diff(heights, axis=axis, append=np.take(heights, [0], axis)))
        for axis in (0, 1)
    ]
    seams = (np.take(step, -1, axis).mean() for axis, step in enumerate(steps))
    return any(seam >= _SEAM**2 * step.mean() for seam, step in zip(seams, steps, strict=True))


def periodic_part(heights: Array) -> Array:
    """Return the periodic part of a map: without the smooth part due to different edges."""
    if not has_seam(heights):
        return heights
    ny, nx = heights.shape
    jump = np.zeros_like(heights)
    for axis in (0, 1):
        first, last = (np.take(heights, index, axis) for index in (0, -1))
        rows = (0, -1) if axis == 0 else ((slice(None), 0), (slice(None), -1))
        jump[rows[0]] += last - first
        jump[rows[1]] -= last - first
    qy, qx = 2 * math.pi * fft.frequencies(ny)[:, None], 2 * math.pi * fft.half_frequencies(nx)
    laplace = 2 * np.cos(qy) + 2 * np.cos(qx) - 4
    laplace[0, 0] = 1.0
    smooth = fft.rfft2(jump) / laplace
    smooth[0, 0] = 0.0
    return heights - fft.irfft2(smooth, heights.shape)


def require_one_surface(maps: Reconstruction) -> None:
    """Raise `InputError` for finer maps with a different spectrum in the common range."""
    place, power = maps._bins(maps.instrument)
    found: list[Array] = []
    for other, (places, powers, variance) in zip(maps.others, maps._finer({}, 0), strict=True):
        if other.limit <= maps.limit:
            raise InputError("must show shorter waves than the map", argument="also")
        both = place >= max(math.log(maps.limit / 2), places[0])
        apart = np.interp(place[both], places, powers) - power[both]
        found.append(np.array([apart, 1 / np.interp(place[both], places, variance)]))
    apart, weight = np.concatenate(found, axis=1)
    if not apart.size:
        raise InputError(
            "shows no waves of the shortest octave that the map shows; measure a larger part",
            argument="also",
        )
    mean = float(np.average(apart, weights=weight))
    if abs(mean) > _SPECTRUM_TOLERANCE + 2 / math.sqrt(weight.sum()):
        raise InputError(
            f"has {math.exp(mean):.2g} times the power of the map in the waves that both show: "
            "they are not of one surface, or an instrument does not resolve what it states",
            argument="also",
        )


def require_octaves(reconstruction: Reconstruction) -> None:
    """Raise `InputError` if the map resolves too few waves of its surface."""
    if reconstruction.limit < 10 / min(_sides(reconstruction)):
        raise InputError(
            f"the map shows its surface down to waves of {1 / reconstruction.limit:.3g} m, more "
            "than a tenth of a side: measure a larger map or with a finer instrument"
        )


def _sides(maps: Reconstruction) -> tuple[float, float]:
    ny, nx = maps.heights.shape
    return ny * maps.pixel[0], nx * maps.pixel[1]


def _resolution_sensitivity(place: Array, instrument: Instrument) -> Array:
    """Return the change of a log spectrum per standard uncertainty of the resolution."""
    q, step = np.exp(place), 0.01
    low, high = (
        np.log(np.maximum(instrument.lateral_transfer(q * factor), 1e-6))
        for factor in (1 - step, 1 + step)
    )
    return np.asarray((low - high) / step * instrument.u_resolution)


def _power(heights: Array) -> Array:
    spectrum = fft.rfft2(heights) / heights.size
    power = np.square(spectrum.real) + np.square(spectrum.imag)
    power[0, 0] = 0.0
    return np.asarray(power)


def _waves(shape: tuple[int, ...], pixel: tuple[float, float]) -> tuple[Array, Array]:
    return fft.frequencies(shape[0], pixel[0])[:, None], fft.half_frequencies(shape[1], pixel[1])


def _directions(qy: Array, qx: Array) -> Array:
    """Return the directions of waves, from 0 to the number of directions."""
    return np.asarray((np.arctan2(qy, qx) / math.pi % 1.0) * _DIRECTIONS)


def _bin_power(k: Array, power: Array, limit: float) -> tuple[Array, Array]:
    """Return logarithm of the wave number, and mean power, of the bins up to a limit."""
    index = np.full(k.shape, -1)
    inside = (k > 0) & (k <= limit * (1 + 1e-9))
    index[inside] = np.ceil(_BINS * np.log2(limit * (1 + 1e-9) / k[inside])).astype(int)
    weight = np.full(k.shape, 2.0)
    weight[:, 0] = 1.0
    chosen = index[inside]
    count, place, total = (
        np.bincount(chosen, weight[inside] * values)
        for values in (1.0, np.log(k[inside]), power[inside])
    )
    full = np.flatnonzero(count)[::-1]
    return place[full] / count[full], total[full] / count[full]
