import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.ndimage import grey_dilation

from roughcontact import units
from roughcontact.cautions import Caution, CautionTag, Severity
from roughcontact.errors import ArgumentRef, InputError, message_parts
from roughcontact.request.preparation import resolution_cautions
from roughcontact.surface import filters, grid, random_surfaces, resolution, spectrum
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

NM = 1e-9
PIXEL = (1 * NM, 1 * NM)


def rough(seed: int, hurst: float = 0.8, rms: float = 4 * NM, shortest: float = 2.5) -> np.ndarray:
    return random_surfaces.self_affine(
        (256, 256),
        PIXEL,
        rms_height=rms,
        rolloff_wavelength=100 * NM,
        cutoff_wavelength=shortest * NM,
        hurst=hurst,
        rng=np.random.default_rng(seed),
    )


def drawn_by(radius: float, heights: np.ndarray) -> np.ndarray:
    """The map that a paraboloidal tip draws: grey dilation by its shape.

    Villarrubia 1997, doi:10.6028/jres.102.030. A paraboloid is a sum of two parabolas,
    hence one dilation along each axis.
    """
    parabola = -((np.arange(-40, 41) * NM) ** 2) / (2 * radius)
    for structure in (parabola[:, None], parabola[None]):
        heights = grey_dilation(heights, structure=structure, mode="wrap")
    return heights


# --- tip ----------------------------------------------------------------------------------------


@given(st.floats(2, 50), st.floats(0.1, 5), st.floats(0.05, 0.5))
def test_single_peaks_drawn_by_a_tip(radius: float, height: float, edge: float) -> None:
    # A spike of height d on a plain is drawn as a parabola of radius R and half width √(2 R d).
    # Wider second differences at its top are -2d/η², which is -1/(2R) at η = 2 √(R d).
    expected = 4 * math.sqrt(radius * height)
    points = int(2.5 * expected / edge) + 5
    x = (np.arange(points) - points // 2) * edge
    drawn = np.maximum(height - x**2 / (2 * radius), 0) * np.ones((2, 1))
    scale = resolution.tip_cutoff(drawn * NM, (NM, edge * NM), radius * NM)
    if expected <= 4 * edge:
        return  # no point on the flanks
    assert scale is not None
    # Between two pixels the curvature is taken as straight.
    assert scale == pytest.approx(expected * NM, rel=0.02, abs=edge * NM)
    # The slopes of a plane change nothing.
    tilted = drawn + 0.3 * x + np.array([[0.0], [5.0]])
    assert resolution.tip_cutoff(tilted * NM, (NM, edge * NM), radius * NM) == pytest.approx(
        scale, rel=1e-6
    )


def test_smooth_maps_are_the_surface_at_every_scale() -> None:
    smooth = random_surfaces.self_affine(
        (128, 256),
        PIXEL,
        rms_height=NM,
        rolloff_wavelength=200 * NM,
        cutoff_wavelength=100 * NM,
        rng=np.random.default_rng(1),
    )
    assert resolution.tip_cutoff(smooth, PIXEL, 20 * NM) is None
    assert resolution.tip_cutoff(np.zeros((2, 3)), PIXEL, 20 * NM) is None
    # A wave a cos qx has the curvature -2a (1 - cos qη)/η² at scale 2η, a q² at most.
    q = 2 * math.pi / 64
    wave = np.cos(q * np.arange(640)) * np.ones((2, 1)) * NM
    sharpest = 2 * (1 - math.cos(q)) / NM
    for factor, flat in ((0.999, True), (1.001, False)):
        scale = resolution.tip_cutoff(wave, PIXEL, factor * 0.5 / sharpest)
        assert (scale is None) == flat


def test_peaks_too_sharp_at_every_scale() -> None:
    ball = -(np.arange(81.0) ** 2) * NM * np.ones((3, 1))
    assert resolution.tip_cutoff(ball, PIXEL, 20 * NM) == pytest.approx(40 * NM)
    assert resolution.tip_cutoff(-ball, PIXEL, 20 * NM) is None  # a valley is no peak


def test_holes_are_ignored() -> None:
    heights = drawn_by(5 * NM, rough(3))
    whole = resolution.tip_cutoff(heights, PIXEL, 5 * NM)
    holed = heights.copy()
    holed[:, ::50] = np.nan
    holed[7] = np.nan
    assert resolution.tip_cutoff(holed, PIXEL, 5 * NM) == pytest.approx(whole, rel=0.1)
    holed[:] = np.nan
    assert resolution.tip_cutoff(holed, PIXEL, 5 * NM) is None


def test_tip_by_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = drawn_by(5 * NM, rough(4))
    whole = resolution.tip_cutoff(heights, PIXEL, 5 * NM)
    monkeypatch.setattr(grid, "VALUES", 1000)
    assert resolution.tip_cutoff(heights, PIXEL, 5 * NM) == whole


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_tip_cutoff_agrees_with_surface_topography(seed: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        library = pytest.importorskip("SurfaceTopography", exc_type=ImportError)
        heights = drawn_by(5 * NM, rough(seed))[:, ::2]
        pixel, size = (NM, 2 * NM), (256 * NM, 256 * NM)
        # Its axes are (x, y).
        theirs = library.Topography(heights.T, size).scanning_probe_reliability_cutoff(5 * NM)
    # It interpolates heights between the pixels, not curvatures.
    ours = resolution.tip_cutoff(heights, pixel, 5 * NM)
    assert ours == pytest.approx(theirs, rel=0.02, abs=pixel[1])


def test_tip_cutoff_refuses() -> None:
    with pytest.raises(InputError, match="tip_radius must be positive"):
        resolution.tip_cutoff(np.zeros((4, 4)), PIXEL, 0.0)
    with pytest.raises(InputError, match="at least 3 columns"):
        resolution.tip_cutoff(np.zeros((4, 2)), PIXEL, NM)
    with pytest.raises(InputError, match="pixel must be positive"):
        resolution.tip_cutoff(np.zeros((4, 4)), (0.0, 1.0), NM)


# --- noise and smoothing ------------------------------------------------------------------------


@pytest.mark.parametrize("hurst", [0.2, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("part", [(slice(None), slice(None)), (slice(17, 217), slice(30, 200))])
def test_rough_maps_have_no_limit(hurst: float, seed: int, part: tuple[slice, slice]) -> None:
    # As a whole periodic, the part not.
    heights = rough(seed, hurst, shortest=2.0000001)[part]
    assert resolution.noise_cutoff(heights, PIXEL) is None
    assert resolution.smoothing_cutoff(heights, PIXEL) is None


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("wave", [10.0, 20.0])
@pytest.mark.parametrize("part", [(slice(None), slice(None)), (slice(17, 217), slice(30, 200))])
def test_noise_is_found_where_it_equals_the_surface(
    seed: int, wave: float, part: tuple[slice, slice]
) -> None:
    heights = rough(seed, shortest=2.0000001)
    q, C, _ = spectrum.radial_spectrum(heights, PIXEL)
    near = np.abs(np.log(q * wave * NM / (2 * math.pi))) < 0.2
    # White noise of RMS height σ has the density σ² Δx Δy.
    sigma = math.sqrt(np.mean(C[near]) / (PIXEL[0] * PIXEL[1]))
    noisy = heights + sigma * np.random.default_rng(seed + 9).normal(size=heights.shape)
    # Bins are 12 % wide, and the density of one map scatters.
    assert resolution.noise_cutoff(noisy[part], PIXEL) == pytest.approx(wave * NM, rel=0.3)
    assert resolution.smoothing_cutoff(noisy[part], PIXEL) is None


def test_white_noise_has_noise_cutoff() -> None:
    noise = np.random.default_rng(1).normal(size=(64, 128))
    assert resolution.noise_cutoff(noise, PIXEL) > 10 * NM
    assert resolution.smoothing_cutoff(noise, PIXEL) is None


@pytest.mark.parametrize("hurst", [0.2, 0.8, 1.0])
@pytest.mark.parametrize("cutoff", [8.0, 20.0])
@pytest.mark.parametrize("part", [(slice(None), slice(None)), (slice(17, 217), slice(30, 200))])
def test_smoothing_is_found_at_the_filter(
    hurst: float, cutoff: float, part: tuple[slice, slice]
) -> None:
    heights = filters.gaussian_lowpass(rough(5, hurst, shortest=2.0000001), PIXEL, cutoff * NM)
    # Exponent -2-2H - 4 ln 2 (λc/λ)² is -6 at 0.95 λc for H = 0.2 and 1.2 λc for H = 1.
    expected = cutoff * NM * math.sqrt(4 * math.log(2) / (4 - 2 * hurst))
    found = resolution.smoothing_cutoff(heights[part], PIXEL)
    assert found == pytest.approx(expected, rel=0.25)
    assert resolution.noise_cutoff(heights[part], PIXEL) is None


def test_a_sharp_end_of_the_spectrum_is_found() -> None:
    heights = rough(6, shortest=8.0)
    assert resolution.smoothing_cutoff(heights, PIXEL) == pytest.approx(8 * NM, rel=0.5)
    # Scales go along with the pixel.
    assert resolution.smoothing_cutoff(heights, (5.0, 5.0)) == pytest.approx(
        5 / NM * resolution.smoothing_cutoff(heights, PIXEL)
    )


def test_regular_grooves_are_not_smoothing() -> None:
    grooves = 20 * NM * np.sin(2 * math.pi * np.arange(256) / 32)
    heights = rough(7, 0.5, 2 * NM, shortest=2.0000001) + grooves
    assert resolution.smoothing_cutoff(heights, PIXEL) is None


def test_small_and_flat_maps_have_no_cutoff() -> None:
    for heights in (np.zeros((64, 64)), np.random.default_rng(1).normal(size=(31, 300))):
        assert resolution.smoothing_cutoff(heights, PIXEL) is None
    assert resolution.noise_cutoff(np.zeros((31, 300)), PIXEL) is None
    holed = np.zeros((64, 64))
    holed[3, 3] = np.nan
    for function in (resolution.noise_cutoff, resolution.smoothing_cutoff):
        with pytest.raises(InputError, match="1 missing points"):
            function(holed, PIXEL)


# --- on a surface --------------------------------------------------------------------------------


def test_notes_of_an_atomic_force_microscope() -> None:
    heights = drawn_by(5 * NM, rough(0))
    about = Provenance("scan.001", "Bruker/Veeco/DI Nanoscope (Bruker Dimension V)")
    (asked,) = Surface(heights, PIXEL, about).resolution_notes()
    assert ArgumentRef("tip_radius") in message_parts(asked)
    (found,) = Surface(heights, PIXEL, about).resolution_notes(tip_radius=5 * NM)
    scale = resolution.tip_cutoff(heights, PIXEL, 5 * NM)
    assert f"Below {units.format_engineering(scale, 'm', 3)} (" in found
    assert f"({scale / NM:.1f} pixels)" in found
    assert "radius 5 nm" in found
    # The radius may be known where the file does not name the instrument.
    assert Surface(heights, PIXEL).resolution_notes() == ()
    assert Surface(heights, PIXEL).resolution_notes(5 * NM) == (found,)
    assert Surface(heights, PIXEL, about).resolution_notes(0.1 * NM) == ()
    with pytest.raises(InputError, match="tip_radius must be positive"):
        Surface(heights, PIXEL).resolution_notes(-1.0)


@pytest.mark.parametrize(
    ("instrument", "is_probe"),
    [
        ("JPK image scan", True),
        ("Nanosurf easyScan", True),
        ("NT-MDT", True),
        ("Park Systems TIFF", True),
        ("WSxM", True),
        ("Igor binary wave", True),
        ("Molecular Imaging (MI)", True),
        ("Digital Surf SUR (Digital Surf AFM 5500)", True),
        ("BCR-STM", False),
        ("BCR-STM (Omicron STM 1)", True),
        ("Digital Surf SUR (Digital Surf)", False),
        ("Wyko OPD", False),
        ("Gwyddion", False),
        ("", False),
    ],
)
def test_which_files_are_a_scanning_probes(instrument: str, is_probe: bool) -> None:
    surface = Surface(np.zeros((4, 4)), PIXEL, Provenance("a", instrument))
    assert bool(surface.resolution_notes()) is is_probe


def test_coarse_pixels_need_no_tip_radius() -> None:
    about = Provenance("a", "WSxM")
    for pixel in ((1.85e-6, 1.85e-6), (1e-8, 2e-6)):
        assert Surface(np.zeros((4, 4)), pixel, about).resolution_notes() == ()


def test_notes_of_noise_and_smoothing() -> None:
    heights = rough(0, shortest=2.0000001)
    noisy = heights + NM * np.random.default_rng(3).normal(size=heights.shape)
    noisy[:20, :20] = np.nan
    (limit,) = Surface(noisy, PIXEL).resolution_limits()
    assert limit.cause is resolution.LimitCause.NOISE
    assert (limit.caution.kind, limit.caution.severity) == (CautionTag.RESOLUTION, Severity.CAUTION)
    smooth = Surface(heights, PIXEL).filtered(s=10 * NM)
    (limit,) = smooth.resolution_limits()
    assert limit.cause is resolution.LimitCause.SMOOTHING
    assert limit.caution.severity is Severity.NOTE
    holed = np.zeros((4, 4))
    holed[::2] = holed[:, ::2] = np.nan
    assert Surface(holed, PIXEL).resolution_notes() == ()


def test_wave_limits_are_cached(monkeypatch: pytest.MonkeyPatch) -> None:
    looks: list[object] = []
    limit = resolution.Limit(resolution.LimitCause.NOISE, NM, "a note")
    monkeypatch.setattr(resolution, "wave_limits", lambda *map: looks.append(map) or [limit])
    surface = Surface(np.zeros((4, 4)), PIXEL)
    assert surface.resolution_notes() == surface.resolution_notes() == ("a note",)
    assert len(looks) == 1


def test_shortest_wave_is_filter_cutoff_on_large_maps() -> None:
    heights = filters.gaussian_lowpass(rough(5, 0.8, shortest=2.0000001), PIXEL, 8 * NM)
    cutoff = resolution.smoothing_cutoff(heights, PIXEL)
    assert resolution.shortest_wave(heights, PIXEL) == pytest.approx(cutoff, rel=0.05)
    assert resolution.shortest_wave(heights[:31], PIXEL) == 2 * NM
    white = np.random.default_rng(1).normal(size=(256, 256))
    assert resolution.shortest_wave(white, PIXEL) > 4 * NM
    assert resolution.shortest_wave(white[:31], (1 * NM, 2 * NM)) == 4 * NM


def test_coarsest_limit_of_several_maps_is_reported_once() -> None:
    def notes_of_maps(*maps: Surface) -> tuple[Caution, ...]:
        return resolution_cautions({"tip-radius": None}, maps)  # type: ignore[arg-type]

    def cautions_of_surface(surface: Surface) -> tuple[Caution, ...]:
        return tuple(limit.caution for limit in surface.resolution_limits())

    heights = rough(0, shortest=2.0000001)
    noise = NM * np.random.default_rng(3).normal(size=heights.shape)
    fine, coarse = (
        Surface(heights + factor * noise, PIXEL, Provenance(name, "Wyko OPD"))
        for name, factor in (("fine.opd", 1.0), ("coarse.opd", 2.0))
    )
    scales = [resolution.noise_cutoff(one.heights, PIXEL) for one in (fine, coarse)]
    assert None not in scales
    assert scales[0] < scales[1]  # type: ignore[operator]
    for maps in ((fine, coarse), (coarse, fine)):
        (result,) = notes_of_maps(*maps)
        assert (result.where, result.place) == ("2 of 2 maps, worst coarse.opd", "coarse.opd")
        assert result.parts == cautions_of_surface(coarse)[0].parts
    assert notes_of_maps(fine) == notes_of_maps(fine, fine) == cautions_of_surface(fine)
    # A limit of one map alone names it; unmeasured maps have none.
    plain = replace(fine, heights=heights, provenance=Provenance("plain.opd", "Wyko OPD"))
    assert notes_of_maps(plain) == ()
    assert notes_of_maps(fine, plain)[0].where == "1 of 2 maps, fine.opd"
    assert notes_of_maps(
        fine, replace(coarse, provenance=Provenance("made"))
    ) == cautions_of_surface(fine)
    # A word for an option stays one.
    probe = Surface(np.zeros((4, 4)), PIXEL, Provenance("scan", "NT-MDT"))
    (asked,) = notes_of_maps(probe, plain)
    assert ArgumentRef("tip_radius") in asked.parts
