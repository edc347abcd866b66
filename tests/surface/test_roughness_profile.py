"""Profiles: one line of heights as a surface, its preparation and its parameters."""

import math
import re

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.surface import roughness

SPACING = 1e-6


def wave(points=5000, length=1e-4, amplitude=1e-6):
    x = np.arange(points) * SPACING
    return x, amplitude * np.sin(2 * np.pi * x / length)


def test_one_line_of_heights_is_a_profile():
    _, z = wave()
    surface = rc.Surface(z, "1 um")
    assert surface.is_profile
    assert surface.shape == (1, 5000)
    assert surface.size[1] == pytest.approx(5e-3)
    assert not rc.Surface(np.zeros((2, 5)), (1e-6, 1e-6)).is_profile
    # Derived surfaces stay profiles.
    assert surface.leveled().is_profile


@pytest.mark.parametrize(
    ("heights", "pixel", "words"),
    [
        (np.zeros((1, 5)), (1e-6, 1e-6), "give the 5 heights as a 1-D array"),
        (np.zeros(5), (1e-6, 1e-6), "one distance of its points"),
        (np.zeros(1), 1e-6, "at least 2 of a profile"),
        (np.zeros(5), 0.0, "positive and finite"),
        (np.full(5, np.nan), 1e-6, "no finite value"),
        (np.zeros((2, 5)), 1e-6, r"pair \(dy, dx\)"),
    ],
)
def test_invalid_profile_raises_input_error(heights, pixel, words):
    with pytest.raises(rc.InputError, match=words):
        rc.Surface(heights, pixel)


def test_the_parameters_of_a_sine_are_known():
    _, z = wave()
    found = rc.Surface(z, SPACING).roughness()
    assert found["Pq"] == pytest.approx(1e-6 / math.sqrt(2), rel=1e-6)
    assert found["Pa"] == pytest.approx(2e-6 / math.pi, rel=1e-3)
    assert found["Pku"] == pytest.approx(1.5, rel=1e-6)
    assert found["Psk"] == pytest.approx(0, abs=1e-4)
    assert found["Pt"] == pytest.approx(2e-6, rel=1e-3)
    assert found["Pz"] == pytest.approx(2e-6, rel=1e-3)
    assert found["Psm"] == pytest.approx(1e-4, rel=1e-4)
    # Three points at each end have no slope.
    assert found["Pdq"] == pytest.approx(2 * np.pi * 1e-2 / math.sqrt(2), rel=1e-3)


def test_small_peaks_are_no_elements():
    x, z = wave()
    # Ripples below a tenth of Rz cross the mean line, and do not count.
    rippled = z + 8e-8 * np.sin(2 * np.pi * x / 9e-6)
    assert roughness.profile_parameters(rippled, SPACING)["Rsm"] == pytest.approx(1e-4, rel=1e-2)
    coarse = z + 1.5e-6 * np.sin(2 * np.pi * x / 2e-5)
    assert roughness.profile_parameters(coarse, SPACING)["Rsm"] < 7e-5


def test_rz_is_a_mean_over_sections_and_rt_is_not():
    z = np.concatenate([amplitude * wave(1000)[1] for amplitude in (1, 2, 3, 4, 5)])
    found = roughness.profile_parameters(z, SPACING, sections=5)
    assert found["Rz"] == pytest.approx(6e-6, rel=1e-3)
    assert found["Rt"] == pytest.approx(1e-5, rel=1e-3)


def test_missing_points_are_ignored():
    _, z = wave()
    z[1234:1240] = np.nan
    found = roughness.profile_parameters(z, SPACING)
    assert found["Rq"] == pytest.approx(1e-6 / math.sqrt(2), rel=5e-3)
    assert found["Rsm"] == pytest.approx(1e-4, rel=1e-2)
    assert math.isfinite(found["Rdq"])


def test_a_flat_profile_has_no_shape_parameters():
    found = roughness.profile_parameters(np.zeros(20), SPACING)
    assert found["Rq"] == found["Rz"] == found["Rdq"] == 0
    assert all(math.isnan(found[name]) for name in ("Rsk", "Rku", "Rsm"))


def test_the_cutoff_is_the_largest_of_which_five_fit():
    assert [
        roughness.profile_cutoff(length) for length in (0.39e-3, 0.4e-3, 4e-3, 12.5e-3, 1.0)
    ] == [None, 0.08e-3, 0.8e-3, 2.5e-3, 8e-3]


def test_a_profile_is_prepared_as_a_map_is():
    rng = np.random.default_rng(1)
    x, z = wave()
    tilted = rc.Surface(z + 3e-3 * x + 1e-4, SPACING)
    for form in ("plane", "robust"):
        assert tilted.leveled(form).Sq == pytest.approx(1e-6 / math.sqrt(2), rel=1e-3)
    bent = rc.Surface(z + 0.5 * x**2, SPACING)
    assert bent.leveled("quadric").Sq == pytest.approx(1e-6 / math.sqrt(2), rel=1e-3)
    assert bent.without_form("polynomial", 2).Sq == pytest.approx(1e-6 / math.sqrt(2), rel=1e-3)
    spiky = z.copy()
    spiky[2000] = 1e-4
    spiky[100:110] = np.nan
    cleaned = rc.Surface(spiky, SPACING).without_outliers()
    assert cleaned.missing == 11
    np.testing.assert_allclose(cleaned.filled().heights[0], z, atol=2e-8)
    assert cleaned.largest_rectangle().shape == (1, 2999)
    assert tilted.cropped((0, 1), (10, 30)).shape == (1, 20)
    assert tilted.resampled(pixel=(2e-6, 2e-6), method="spline").shape == (1, 2500)
    assert np.array_equal(tilted.rotated(180).heights[0], tilted.heights[0, ::-1])
    arc = np.sqrt(0.05**2 - (x - 2.5e-3) ** 2) + 1e-8 * rng.standard_normal(x.size)
    rest = rc.Surface(arc, SPACING).without_form("cylinder")
    assert rest.Sq == pytest.approx(1e-8, rel=0.05)
    (radius,) = re.findall(r"radius ([0-9.]+) mm", rest.provenance.steps[-1])
    assert float(radius) == pytest.approx(50, rel=1e-3)


def test_a_filter_passes_half_of_a_wave_at_its_cutoff():
    # ISO 16610-21, away from the ends.
    _, z = wave(points=8000)
    surface = rc.Surface(z, SPACING)
    for filtered in (surface.filtered(s=1e-4), surface.filtered(l=1e-4)):
        middle = filtered.heights[0, 2000:6000]
        assert np.ptp(middle) == pytest.approx(1e-6, rel=1e-3)
    with pytest.raises(rc.InputError, match=r"2 µm to 8 mm"):
        surface.filtered(s=1e-2)


# In files


def traced(uneven=0.0):
    """Positions [mm] and heights [µm] of a rough trace."""
    rng = np.random.default_rng(3)
    x = np.arange(2000) * 5e-4
    z = np.convolve(rng.standard_normal(2010), np.ones(11) / 11, "valid")
    return np.sort(x + uneven * rng.uniform(-1, 1, x.size)), z


def write_profile(path, x, z, head="", mark="\t", comma=False):
    lines = [f"{a:.7f}{mark}{b:.6f}" for a, b in zip(x, z, strict=True)]
    text = "\n".join(lines) + "\n"
    path.write_text(head + (text.replace(".", ",") if comma else text), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("name", "options", "unit"),
    [
        ("a.txt", {"head": "X [mm]\tZ [um]\n"}, None),
        (
            "b.csv",
            {"head": "Run 1\nDate;2024\n\nx (mm);z (µm)\n", "mark": ";", "comma": True},
            None,
        ),
        ("c.txt", {"mark": "  "}, "mm, um"),
        ("f.txt", {"mark": " ", "head": "X [mm] Z [um]\n"}, None),
        ("d.csv", {"mark": ",", "head": "# mm, um\n"}, None),
        ("e.asc", {"mark": "\t", "comma": True}, "mm, um"),
    ],
)
def test_two_columns_are_a_profile(tmp_path, name, options, unit):
    x, z = traced()
    path = write_profile(tmp_path / name, x, z, **options)
    surface = rc.read_surface(path, unit=unit)
    assert surface.is_profile
    assert surface.pixel[1] == pytest.approx(5e-7, rel=1e-9)
    np.testing.assert_allclose(surface.heights[0], 1e-6 * z, atol=1e-12)
    assert surface.provenance.steps == ()
    (channel,) = rc.formats.read.channels(path)
    assert channel.shape == (1, 2000)


DEKTAK = (
    "Scan Parameters\nID,0\nStylus,Radius: 2.5 µm\nLength,1500.0 um\n\nAnalytical Results\n"
    "Skew,468.0 um,0.0 um,733.0 um,0.0 um,6.96\n\nScan Data\nLateral um,Raw Micrometer,\n"
)
INDEXED = "index,x in µm,y in µm\n"


@pytest.mark.parametrize(
    ("name", "head", "row", "encoding", "unit"),
    [
        ("a.csv", DEKTAK, "{x:.4f},{z:.7f},,", "cp1252", None),
        ("b.csv", INDEXED, "{n},{x:.4f},{z:.7f}", "utf-16", None),
        ("c.csv", INDEXED, "{n},{x:.4f},{z:.7f}", "utf-16-le", None),
        ("d.csv", "X_(microns),y1\n", "{x:.4f},{z:.7f}", "utf-8", "um"),
        ("e.txt", "µm µm\n2000\n", "   {x:.4e},   {z:.7e}", "utf-8", None),
        ("f.txt", "µm µm\n1999\n", "{x:.4f}\t{z:.7f}", "cp1252", None),
        ("g.hfm", "X;Y;valid\n[um];[um];[1/0]\n", "{x:.4f};{z:.7f};1", "utf-8", None),
        ("h.asc", "", "{x:.4f} {z:.7f}", "utf-8", "um, um"),
    ],
)
def test_profiles_as_other_programs_write_them(tmp_path, name, head, row, encoding, unit):
    z = traced()[1]
    lines = [row.format(n=n, x=0.5 * n, z=height) for n, height in enumerate(z)]
    path = tmp_path / name
    path.write_bytes((head + "\n".join(lines) + "\n").encode(encoding))
    surface = rc.read_surface(path, unit=unit)
    assert surface.is_profile
    assert surface.pixel[1] == pytest.approx(5e-7, rel=1e-9)
    np.testing.assert_allclose(surface.heights[0], 1e-6 * z, atol=1e-12)
    assert rc.formats.read.channels(path)[0].shape == (1, 2000)


def test_points_marked_as_not_valid_are_missing(tmp_path):
    path = tmp_path / "t.hfm"
    rows = (f"{n};{n % 3};{int(n != 5)}" for n in range(20))
    path.write_text("X;Y;valid\n[mm];[um];[1/0]\n" + "\n".join(rows) + "\n", encoding="utf-8")
    surface = rc.read_surface(path)
    assert surface.pixel[1] == pytest.approx(1e-3)
    assert np.flatnonzero(np.isnan(surface.heights[0])).tolist() == [5]


@pytest.mark.parametrize("stated", ["", "X_(microns),y1\n"])
def test_one_unit_for_two_columns_raises_input_error(tmp_path, stated):
    x, z = traced()
    path = write_profile(tmp_path / "t.csv", x, z, head=stated, mark=",")
    with pytest.raises(rc.InputError, match=r"^t\.csv is a profile .* give .*unit="):
        rc.read_surface(path)
    if stated:
        # That of the heights: the file gives the other.
        surface = rc.read_surface(path, unit="nm")
        assert surface.size[1] == pytest.approx(1e-6 * (x[-1] + 5e-4))
        assert np.ptp(surface.heights) == pytest.approx(1e-9 * np.ptp(z))
    else:
        with pytest.raises(rc.InputError, match=r"needs two units, .*'um'.*unit=\"mm, um\""):
            rc.read_surface(path, unit="um")


def test_single_number_does_not_make_profile(tmp_path):
    x, z = traced()
    path = write_profile(tmp_path / "t.txt", x, z, head="mm um\n17\n")
    with pytest.raises(rc.FormatError):
        rc.read_surface(path)


def test_positions_even_but_for_their_last_digit_are_not_interpolated(tmp_path):
    z = traced()[1]
    rows = (f"{0.15625 * n:.1f},{height:.6f}\n" for n, height in enumerate(z))
    path = tmp_path / "t.csv"
    path.write_text("Lateral um,Raw Micrometer\n" + "".join(rows), encoding="utf-8")
    surface = rc.read_surface(path)
    assert surface.shape == (1, 2000)
    assert surface.pixel[1] == pytest.approx(0.15625e-6, rel=1e-4)
    np.testing.assert_allclose(surface.heights[0], 1e-6 * z, atol=1e-12)
    assert "100 nm" in surface.provenance.steps[0]


def test_uneven_points_are_resampled_with_step(tmp_path):
    x, _ = traced(uneven=2e-4)
    path = write_profile(tmp_path / "t.txt", x, np.sin(20 * x))
    surface = rc.read_surface(path, unit="mm, um")
    (note,) = surface.provenance.steps
    assert "resampled to" in note
    assert "linear interpolation" in note
    even = 1e3 * (x[0] * 1e-3 + surface.pixel[1] * np.arange(surface.shape[1]))
    np.testing.assert_allclose(surface.heights[0], 1e-6 * np.sin(20 * even), atol=1e-10)
    assert surface.size[1] == pytest.approx(1e-3, rel=1e-2)


def test_rounded_positions_are_even(tmp_path):
    x, z = traced()
    # Steps of 0.1967 µm, of which a nanometre is printed.
    path = tmp_path / "t.txt"
    lines = (f"{a:.6f}\t{b:.6f}\n" for a, b in zip(0.39341 * x, z, strict=True))
    path.write_text("".join(lines))
    surface = rc.read_surface(path, unit="mm, um")
    assert surface.shape == (1, 2000)
    assert surface.provenance.steps == ()
    assert surface.pixel[1] == pytest.approx(0.39341 * 5e-7, rel=1e-5)


def test_falling_positions_are_read_from_the_other_end(tmp_path):
    x, z = traced()
    path = write_profile(tmp_path / "t.txt", x[::-1], z)
    np.testing.assert_allclose(
        rc.read_surface(path, unit="mm, um").heights[0, ::-1], 1e-6 * z, atol=1e-12
    )


def test_a_gap_of_the_trace_is_missing(tmp_path):
    x, z = traced()
    kept = np.r_[0:700, 760:2000]
    surface = rc.read_surface(write_profile(tmp_path / "t.txt", x[kept], z[kept]), unit="mm, um")
    assert surface.shape == (1, 2000)
    assert np.array_equal(np.flatnonzero(np.isnan(surface.heights[0])), np.arange(700, 760))


def test_units_and_length_of_profile_are_required_or_replaced(tmp_path):
    x, z = traced()
    bare = write_profile(tmp_path / "bare.txt", x, z)
    with pytest.raises(rc.InputError, match=r'gives no units of its positions.*unit="mm, um"'):
        rc.read_surface(bare)
    stated = write_profile(tmp_path / "stated.txt", x, z, head="x [mm]\tz [um]\n")
    found = rc.read_surface(stated, unit="mm, nm")
    assert found.provenance.steps == ("read: units mm and um of the file replaced by mm, nm",)
    assert np.ptp(found.heights) == pytest.approx(1e-9 * np.ptp(z))
    with pytest.raises(rc.InputError, match="contains its size"):
        rc.read_surface(stated, size="2 mm")
    found = rc.read_surface(stated, size="2 mm", override_size=True)
    assert found.size[1] == pytest.approx(2e-3)
    assert "sides of 1 mm, as the file gives them, replaced by 2 mm" in found.provenance.steps[0]
    column = tmp_path / "column.txt"
    np.savetxt(column, z)
    with pytest.raises(rc.InputError, match="is a profile and gives no length"):
        rc.read_surface(column, unit="um")
    assert rc.read_surface(column, unit="um", size="1 mm").pixel[1] == pytest.approx(5e-7)
    # A map that was cut off in its first line is no profile.
    cut = tmp_path / "cut.csv"
    cut.write_text(",".join(f"{height:.4f}" for height in z), encoding="utf-8")
    for path in (column, cut):
        with pytest.raises(rc.InputError, match=r'single line.*size="2 mm".*was it cut off'):
            rc.read_surface(path, unit="um", size="1 mm x 2 mm")
        surface = rc.read_surface(path, unit="um", size="2 mm")
        again = rc.read_surface(path, unit="um", size=surface.size)
        np.testing.assert_array_equal(again.heights, surface.heights)


def test_the_roughness_of_a_file_is_without_waves_beyond_the_cutoff():
    from roughcontact.report import inputs

    # A wave well below λc = 0.8 mm, one well beyond it.
    x = np.arange(9600) * 5e-7
    rough, form = (a * np.sin(2 * np.pi * x / w) for a, w in ((1e-6, 8e-5), (5e-6, 4.8e-3)))
    surface = rc.Surface(rough + form, 5e-7).leveled("mean")
    found = inputs.filtered_parameters(surface)
    assert found["Rq"] == pytest.approx(1e-6 / math.sqrt(2), rel=2e-2)
    assert found["Rsm"] == pytest.approx(8e-5, rel=1e-2)
    assert found["Rz"] == pytest.approx(2e-6, rel=5e-2)
    assert surface.roughness()["Pq"] > 3e-6


@pytest.mark.parametrize("phase", [0.1, 0.4, 1.3])
def test_elements_are_measured_between_points(phase):
    # Two crossings of few points each: a share of a point that is missed is seen.
    points = 10.37
    heights = 1e-6 * np.sin(2 * np.pi * np.arange(26) / points + phase)
    found = roughness.element_width(heights, 1e-6, 1e-8)
    assert found == pytest.approx(points * 1e-6, rel=3e-3)
