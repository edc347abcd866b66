"""Figures of the volume show what is stored, at its place, in its unit."""

import dataclasses
import io

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.drawing import elastoplastic
from roughcontact.errors import InputError


def every_figure(result: rc.ElastoplasticResult) -> list[Figure]:
    return [
        elastoplastic.residual_displacement(result),
        elastoplastic.section(result),
        elastoplastic.section(result, "y", width=6e-6),
        elastoplastic.profile(result),
        elastoplastic.layers(result),
        elastoplastic.path(result),
        elastoplastic.convergence(result),
    ]


def titled(figure: Figure, words: str):
    """Return the axes whose title has these words."""
    (found,) = [axes for axes in figure.axes if words in axes.get_title(loc="left")]
    return found


@pytest.fixture(scope="module")
def untouched() -> rc.ElastoplasticResult:
    """A state in which nothing has yielded."""
    y, x = np.mgrid[:16, :16] - 8
    surface = rc.Surface(-(y**2 + x**2) * (0.5e-6) ** 2 / 2e-4, (0.5e-6, 0.5e-6))
    steel = rc.Material(210e9, 0.3, 20e9)
    return rc.solve_elastoplastic(surface, material=steel, increments=1, loads=[0.05])


@pytest.mark.slow
@pytest.mark.long
def test_every_figure_is_rendered_without_warnings(loaded, released, untouched, unmoved) -> None:
    for result in (loaded, released, untouched, unmoved):
        for figure in every_figure(result):
            # Warnings are errors here; too small a layout would warn.
            figure.savefig(io.BytesIO(), format="png", dpi=40)


def test_section_is_true_to_scale_and_shows_every_layer(loaded) -> None:
    figure = elastoplastic.section(loaded, "x")
    stored = loaded.section("x")
    axes = titled(figure, "accumulated plastic strain [%]")
    (mesh,) = [c for c in axes.collections if hasattr(c, "_coordinates")]
    drawn = mesh.get_array()
    rows, columns = drawn.shape
    assert columns == 32
    shown = np.where(stored.accumulated[:rows] > 0, 100 * stored.accumulated[:rows], np.nan)
    np.testing.assert_allclose(np.ma.filled(drawn, np.nan), shown)
    faces = mesh._coordinates[:, 0, 1]
    np.testing.assert_allclose(faces, 1e6 * stored.faces[: rows + 1])
    # Inches per micrometer are equal down and across.
    box = axes.get_position()
    width, height = figure.get_size_inches()
    left, right = axes.get_xlim()
    bottom, top = axes.get_ylim()
    assert top == 0
    down = box.height * height / bottom
    assert box.width * width / (right - left) == pytest.approx(down)
    # It reaches below the plastic zone.
    assert bottom > 1e6 * loaded.plastic_depth
    # No axes overlap.
    renderer = FigureCanvasAgg(figure).get_renderer()
    panels = [a.get_tightbbox(renderer) for a in figure.axes]
    for number, one in enumerate(panels):
        for other in panels[number + 1 :]:
            assert not one.padded(-1).overlaps(other.padded(-1))


def test_section_compares_the_stress_with_the_strength_at_its_place(loaded) -> None:
    axes = titled(elastoplastic.section(loaded), "yield strength")
    (mesh,) = [c for c in axes.collections if hasattr(c, "_coordinates")]
    stored = loaded.section()
    rows = mesh.get_array().shape[0]
    ratio = (stored.von_mises / stored.strength)[:rows]
    np.testing.assert_allclose(mesh.get_array(), np.minimum(ratio, 1))
    # Under load only.
    assert mesh.get_clim() == (0, 1)


def test_narrow_section_is_centered_on_largest_strain(loaded) -> None:
    figure = elastoplastic.section(loaded, "x", width=5e-6)
    axes = titled(figure, "pressure")
    left, right = axes.get_xlim()
    assert right - left == pytest.approx(5)
    assert left < 17.5 * 0.5 < right
    assert (left + right) / 2 == pytest.approx(17.5 * 0.5, abs=0.5)


def test_unloaded_section_shows_residual_stress_only(loaded, released) -> None:
    titles = [a.get_title(loc="left") for a in elastoplastic.section(released).figure.axes]
    assert not any("load" in title or "pressure" in title for title in titles)
    assert sum("residual stress" in title for title in titles) == 2
    labels = [
        text.get_text()
        for result in (loaded, released)
        for axes in elastoplastic.profile(result).axes
        if (legend := axes.get_legend())
        for text in legend.get_texts()
    ]
    assert labels.count("under load") == 1
    assert labels.count("yield strength") == 2


def test_profile_draws_the_components(loaded) -> None:
    figure = elastoplastic.profile(loaded)
    stored = loaded.profile()
    steps = {p.get_label(): p.get_data() for axes in figure.axes for p in axes.patches}
    np.testing.assert_allclose(steps["yield strength"].values, stored.strength / 1e9, rtol=1e-6)
    for axis, name in enumerate("xyz"):
        values = stored.residual_stress[:, axis, axis] / 1e6
        np.testing.assert_allclose(steps[rf"$\sigma_{{{name * 2}}}$"].values, values, rtol=1e-6)
    np.testing.assert_allclose(steps["under load"].edges, 1e6 * stored.faces)


def test_path_separates_loading_and_unloading(released) -> None:
    figure = elastoplastic.path(released)
    axes = figure.axes[0]
    lines = {line.get_label(): line.get_xydata() for line in axes.get_lines()}
    loading, unloading = (
        line[np.isfinite(line).all(axis=1)] for line in (lines["loading"], lines["unloading"])
    )
    assert loading[:, 0].tolist() == pytest.approx([0, 100, 100, 200, 200, 350])
    assert unloading[:, 0].tolist() == pytest.approx([350, 0])
    approach = 1e9 * released.increments[-1].approach
    assert unloading[-1, 1] == pytest.approx(approach)
    assert lines["end"][0].tolist() == pytest.approx([0, approach])
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "approach [nm]",
        "contact area [µm²]",
        "largest pressure [GPa]",
        "largest plastic strain [%]",
    ]


def test_convergence_draws_every_iteration(released) -> None:
    axes = elastoplastic.convergence(released).axes[0]
    *lines, tolerance = axes.get_lines()
    assert len(lines) == len(released.increments)
    drawn = np.concatenate([line.get_xydata() for line in lines])
    np.testing.assert_array_equal(drawn[:, 0], np.arange(1, released.iterations + 1))
    residuals = [r for step in released.increments for r in step.residuals]
    np.testing.assert_array_equal(drawn[:, 1], residuals)
    assert set(tolerance.get_ydata()) == {released.tolerance}


def test_convergence_shows_residuals_that_grow_at_first(loaded) -> None:
    # Acceleration may raise the residual far above that of the first iteration.
    step = dataclasses.replace(loaded.increments[0], residuals=(0.01, 0.5, 1e-5))
    axes = elastoplastic.convergence(dataclasses.replace(loaded, increments=(step,))).axes[0]
    assert axes.get_ylim()[1] > 0.5


def test_displacement_is_centred_on_zero_and_shows_the_contact(loaded, released) -> None:
    axes = elastoplastic.residual_displacement(loaded).axes[0]
    (image,) = axes.images
    np.testing.assert_allclose(image.get_array(), 1e9 * loaded.residual_displacement)
    low, high = image.get_clim()
    assert low == -high or low == 0
    (line,) = axes.collections
    pixels = np.array([np.mean(s, axis=0) for s in line.get_segments()])
    touching = loaded.contact.contact
    ends = np.flatnonzero(touching.any(axis=0))[[0, -1]] + [0, 1]
    assert [pixels[:, 0].min(), pixels[:, 0].max()] == pytest.approx((0.5 * ends).tolist())
    (line,) = elastoplastic.residual_displacement(released).axes[0].collections
    assert len(line.get_segments()) == 0


def test_unconverged_result_is_marked(loaded) -> None:
    stopped = dataclasses.replace(loaded, status="stopped before 9 N")
    for figure in every_figure(stopped):
        words = figure.get_suptitle() + "".join(axes.get_title() for axes in figure.axes)
        assert "NOT CONVERGED" in words


@pytest.mark.parametrize("width", [0.0, -1e-6, np.inf, np.nan])
def test_bad_widths(loaded, width: float) -> None:
    with pytest.raises(InputError, match="width"):
        elastoplastic.section(loaded, width=width)
