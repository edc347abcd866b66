import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact import plots
from roughcontact.analyses.stress import model as subsurface_stress
from roughcontact.surface import shapes

STEEL = rc.Material(210e9, 0.3, yield_strength=1e9)
PIXEL = (1e-6, 1e-6)


def stress_below(load, shape=(64, 80), material=STEEL, depths=None, radius=2e-3, **options):
    surface = rc.Surface(shapes.paraboloid(shape, PIXEL, radius), PIXEL)
    result = rc.solve(surface, material=material, counter_material=STEEL, load=load, ceiling=None)
    return subsurface_stress.subsurface_stress(result, depths, **options)


@pytest.fixture(scope="module")
def light():
    return stress_below(0.2)


@pytest.fixture(scope="module")
def heavy():
    return stress_below(3.0, radius=5e-4)


def texts(figure):
    from matplotlib.text import Text

    return "\n".join(text.get_text() for text in figure.findobj(Text))


@pytest.mark.slow
@pytest.mark.long
def test_every_figure_is_rendered_without_warnings(light, heavy):
    cases = [
        light,
        heavy,
        stress_below(0.2, friction=0.5, in_body="counter_body"),
        stress_below(0.2, shape=(12, 90)),
        stress_below(0.2, shape=(90, 12)),
        stress_below(0.2, material=rc.Material(210e9, 0.3)),
        stress_below(0.2, depths=[1e-7, 1e-6]),
    ]
    for result in cases:
        for figure in (
            plots.stress_depth(result),
            plots.stress_section(result),
            plots.stress_section(result, "y", depth=3e-6),
            plots.stress_map(result),
        ):
            figure.draw_without_rendering()


def test_depth_draws_the_profile_in_its_units(light):
    figure = plots.stress_depth(light)
    (axes,) = figure.axes
    profile = light.profile
    mises, tresca, shear = axes.lines[:3]
    for line, values in (
        (mises, profile.von_mises),
        (tresca, profile.tresca),
        (shear, profile.orthogonal_shear.max(axis=1)),
    ):
        np.testing.assert_allclose(line.get_xdata(), profile.depths * 1e6)
        np.testing.assert_allclose(line.get_ydata(), values * 1e-9)
    assert axes.get_xlabel() == "depth [µm]"
    assert axes.get_ylabel() == "stress [GPa]"
    assert "yield strength 1 GPa" in texts(figure)
    unknown = plots.stress_depth(stress_below(0.2, material=rc.Material(210e9, 0.3)))
    assert "yield strength" not in texts(unknown)


def test_depth_axis_shows_a_maximum_near_the_surface(light):
    assert plots.stress_depth(light).axes[0].get_xscale() == "linear"
    near = stress_below(0.2, friction=0.6)
    assert near.profile.depth_of_max < 1e-6
    assert plots.stress_depth(near).axes[0].get_xscale() == "symlog"


@pytest.mark.parametrize("along", ["x", "y"])
def test_section_shows_the_plane(light, along):
    figure = plots.stress_section(light, along, depth=30e-6)
    axes = figure.axes[0]
    mesh = axes.collections[0]
    values = np.asarray(mesh.get_array())
    side = 80 if along == "x" else 64
    assert values.shape[1] == side
    assert axes.get_xlim() == pytest.approx((0, side))
    assert axes.get_ylim() == pytest.approx((30, 0))
    # Linear between the depths: on the row nearest to one of them it is the stress there.
    number = int(light.profile.von_mises.argmax())
    row = int(light.profile.depths[number] / 30e-6 * values.shape[0])
    expected = light.von_mises_section(along)[number] * 1e-6
    np.testing.assert_allclose(values[row], expected, rtol=0.01, atol=1)
    (cross,) = axes.lines
    depth, y, x = light.max_von_mises_at
    assert cross.get_xdata()[0] == pytest.approx((x if along == "x" else y) * 1e6)
    assert cross.get_ydata()[0] == pytest.approx(depth * 1e6)
    assert "at depth" in axes.get_title()


def test_default_section_contains_largest_stress(light):
    axes = plots.stress_section(light).axes[0]
    deep = axes.get_ylim()[0] * 1e-6
    plane = light.von_mises_section("x").max(axis=1)
    assert np.interp(deep, light.profile.depths, plane) <= 0.26 * plane.max()
    shallow = stress_below(0.2, depths=[1e-7, 2e-6])
    assert plots.stress_section(shallow).axes[0].get_ylim()[0] == pytest.approx(2)
    assert plots.stress_section(shallow, depth=1.0).axes[0].get_ylim()[0] == pytest.approx(2)


@pytest.mark.parametrize("along", ["x", "y"])
def test_section_zooms_to_where_the_stress_is(along):
    # A contact of 3 µm radius on a map of 120 × 200 µm, off its middle.
    y, x = np.mgrid[:120, :200] * 1e-6
    surface = rc.Surface(-((x - 50e-6) ** 2 + (y - 90e-6) ** 2) / 1e-3, PIXEL)
    result = subsurface_stress.subsurface_stress(rc.solve(surface, material=STEEL, load=0.01))
    axes = plots.stress_section(result, along).axes[0]
    (first, last), deep = axes.get_xlim(), axes.get_ylim()[0]
    middle = 50 if along == "x" else 90
    assert 20 <= last - first <= 40
    assert (first + last) / 2 == pytest.approx(middle, abs=2)
    assert 0.3 * (last - first) < deep < 20
    # Large stresses are within it, and fill a good part of it.
    seen = np.asarray(axes.collections[0].get_array())
    strong = seen > 0.25 * seen.max()
    assert not strong[:, [0, -1]].any()
    assert np.mean(strong.any(axis=0)) > 0.25
    whole = plots.stress_section(result, along, width=1.0).axes[0]
    assert whole.get_xlim() == pytest.approx((0, 200 if along == "x" else 120))
    narrow = plots.stress_section(result, along, width=10e-6).axes[0]
    assert np.diff(narrow.get_xlim()) == pytest.approx(10)


@pytest.mark.long
def test_units_fit_visible_range():
    # The largest stress lies 1 µm deep; depths extend to 2 mm.
    near = stress_below(0.2, friction=0.6, depths=[3e-7, 1e-6, 1e-5, 1e-4, 2e-3])
    axes = plots.stress_depth(near).axes[0]
    assert axes.get_xlabel() == "depth [µm]"
    assert "nm" not in axes.get_title()
    y, x = np.mgrid[:60, :1200] * 1e-6
    surface = rc.Surface(-((x - 600e-6) ** 2 + (y - 30e-6) ** 2) / 1e-3, PIXEL)
    result = subsurface_stress.subsurface_stress(rc.solve(surface, material=STEEL, load=1e-4))
    axes = plots.stress_section(result).axes[0]
    assert axes.get_xlabel() == "x [µm]"
    assert axes.get_ylabel() == "depth [µm]"
    assert "µm" in axes.get_title()
    assert "nm" not in axes.get_title()


def test_map_shows_peak_and_yielded_part(light, heavy):
    figure = plots.stress_map(light)
    image = figure.axes[0].images[0]
    np.testing.assert_allclose(image.get_array(), light.profile.peak * 1e-6, rtol=1e-6)
    assert image.get_clim() == pytest.approx((0, light.max_von_mises * 1e-6))
    assert "exceeded" not in texts(figure)
    figure = plots.stress_map(heavy)
    assert figure.axes[0].images[0].get_clim() == pytest.approx((0, 1))
    share = 100 * np.count_nonzero(heavy.profile.peak > 1e9) / heavy.profile.peak.size
    assert f"exceeded below {share:.1f} % of the map" in texts(figure)
    assert "black: above yield" in texts(plots.stress_section(heavy))
    (cross,) = figure.axes[0].lines
    assert cross.get_xdata()[0] == pytest.approx(heavy.max_von_mises_at[2] * 1e6)
    assert cross.get_ydata()[0] == pytest.approx(heavy.max_von_mises_at[1] * 1e6)


def test_bad_arguments(light):
    with pytest.raises(rc.InputError, match=r"along.*'z'"):
        plots.stress_section(light, "z")
    with pytest.raises(rc.InputError, match="width must be positive"):
        plots.stress_section(light, width=0.0)
    for depth in (0.0, -1e-6, math.inf):
        with pytest.raises(rc.InputError, match="depth must be positive"):
            plots.stress_section(light, depth=depth)
    with pytest.raises(rc.InputError, match="two depths"):
        plots.stress_section(stress_below(0.2, depths=[1e-6]))
