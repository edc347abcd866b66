import dataclasses
import io
import itertools
import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import imread
from numpy.typing import NDArray
from PIL import Image

from roughcontact import plots
from roughcontact.analyses.history.model import Stage, history as load_history
from roughcontact.analyses.sweep.model import LoadCurve, LoadStep
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import solve
from roughcontact.drawing import export, style
from roughcontact.errors import InputError, RoughcontactError
from roughcontact.material.material import Material
from roughcontact.surface import roughness
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import format_percent

GIGA = 1e9


def result_of(
    pressure: NDArray[np.float64],
    ceiling: float | NDArray[np.float64] | None = 3 * GIGA,
    pixel: tuple[float, float] = (1e-6, 1e-6),
    missing: NDArray[np.bool_] | None = None,
    status: str = "converged",
) -> ContactResult:
    """Return a result with this pressure, without solving anything."""
    heights = np.random.default_rng(1).normal(scale=1e-7, size=pressure.shape)
    if missing is not None:
        heights[missing] = np.nan
    gap = np.where(pressure > 0, 0.0, np.nanmax(heights) - heights)
    return ContactResult(
        pair=Pair(Surface(heights, pixel), Material(210e9, 0.3, GIGA)),
        ceiling=ceiling,
        precision="double",
        tolerance=1e-6,
        control="load",
        load=float(pressure.sum()) * pixel[0] * pixel[1],
        approach=1e-7,
        pressure=pressure.copy(),
        gap=gap,
        certificate=4.7e-7,
        load_error=0.0,
        status=status,
        iterations=1,
        convolutions=1,
        seconds=0.0,
    )


def spotted_pressure(shape: tuple[int, int] = (40, 60)) -> NDArray[np.float64]:
    """Return a pressure with 5 % elastic and 1 % saturated points (for 40 × 60)."""
    pressure = np.zeros(shape)
    pressure[10:20, 20:32] = 2 * GIGA
    pressure[12:16, 22:28] = 3 * GIGA
    return pressure


def every_figure(result: ContactResult) -> list[Figure]:
    return [
        plots.surface(result.surface),
        plots.pressure(result),
        plots.contact(result),
        plots.gap(result),
        plots.pressure_histogram(result),
        plots.pressure_histogram([result, result], ["a", "b"], scale="log"),
        plots.comparison([result, result], ["a", "b"]),
        plots.overview(result),
    ]


def every_detail(result: ContactResult) -> list[Figure]:
    return [
        plots.section(result),
        plots.section(result, 4e-6),
        plots.close_up(result, (1, 1), 4e-6),
        plots.bearing_curve(result.surface),
        plots.spots(result),
    ]


def maps(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if axes.images]


def drawn_array(axes: Axes) -> Any:
    return axes.images[0].get_array()


def shares(axes: Axes) -> NDArray[np.float64]:
    """Return the drawn share of each class, (ny, nx, 4): open, elastic, saturated, missing."""
    names = (style.OPEN, style.ELASTIC, style.SATURATED, style.MISSING)
    mixing = np.array([[*mpl.colors.to_rgb(name), 1.0] for name in names]).T
    seen = np.asarray(drawn_array(axes)) - style.HALF_A_STEP
    seen = np.concatenate([seen, np.ones((*seen.shape[:-1], 1))], axis=-1)
    return np.asarray(seen @ np.linalg.inv(mixing).T)


def texts(figure: Figure) -> str:
    from matplotlib.text import Text

    return "\n".join(text.get_text() for text in figure.findobj(Text))


def rendered(figure: Figure) -> NDArray[np.float64]:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=style.DPI)
    stream.seek(0)
    return np.asarray(imread(stream))[..., :3]


@pytest.mark.long
@pytest.mark.parametrize(
    ("pressure", "ceiling"),
    [
        (np.zeros((8, 8)), 3 * GIGA),
        (np.full((8, 8), 3 * GIGA), 3 * GIGA),
        (np.full((8, 8), 1e3), None),
        (np.eye(8) * GIGA, np.where(np.arange(64).reshape(8, 8) % 2, GIGA, np.inf)),
    ],
    ids=["nothing touches", "all saturated", "full elastic contact", "ceiling by point"],
)
def test_limiting_cases_are_drawn(
    pressure: NDArray[np.float64], ceiling: float | NDArray[np.float64] | None
) -> None:
    for figure in every_figure(result_of(pressure, ceiling)):
        figure.draw_without_rendering()
    for figure in every_detail(result_of(pressure, ceiling)):
        assert figure.axes


def test_flat_surface_is_drawn() -> None:
    flat = Surface(np.full((9, 9), 1e-3), (1e-6, 1e-6))
    plots.surface(flat).draw_without_rendering()
    plots.bearing_curve(flat).draw_without_rendering()


def test_axes_are_true_in_engineering_units() -> None:
    result = result_of(spotted_pressure(), pixel=(2e-6, 1e-6))
    (axes,) = maps(plots.pressure(result))
    assert axes.get_xlabel() == "x [µm]"
    assert axes.get_xlim() == pytest.approx((0, 60))
    assert axes.get_ylim() == pytest.approx((80, 0))
    assert axes.get_aspect() == 1
    (axes,) = maps(plots.surface(Surface(np.eye(20), (1e-4, 1e-4))))
    assert axes.get_xlabel() == "x [mm]"


def test_a_figure_has_one_unit() -> None:
    # Sq 779 nm below colours in micrometres; a close-up far out on a map of millimetres.
    heights = np.random.default_rng(2).normal(scale=779e-9, size=(60, 60))
    figure = plots.surface(Surface(heights, (1e-6, 1e-6)))
    assert "Sq 0.7" in texts(figure)
    assert "height above mean [µm]" in texts(figure)
    assert "nm" not in texts(figure)
    # A mean spot of 0.5 µm² on an axis in square micrometres.
    pressure = np.zeros((20, 40))
    pressure[2, [2, 3, 4, 8, 10, 12]] = GIGA
    figure = plots.spots(result_of(pressure, pixel=(0.5e-6, 0.6e-6)))
    assert "mean area 0.45 µm²" in texts(figure)
    # 3.9 µm around a point 1 mm from the corner.
    small = np.zeros((4, 8000))
    small[2, 7990] = GIGA
    left, _ = maps(plots.close_up(result_of(small, pixel=(130e-9, 130e-9)), (2, 7990), 0.9e-6))
    assert left.get_xlabel() == "x [µm]"
    assert left.get_xlim()[1] == pytest.approx(1039.0, abs=0.5)


def test_block_reduction_keeps_the_axes_true() -> None:
    # 1301 points do not divide into cells: the last ones reach beyond the map and are cut off.
    result = result_of(np.pad(spotted_pressure(), ((0, 0), (1301 - 60, 0))))
    (axes,) = maps(plots.pressure(result))
    shape = drawn_array(axes).shape
    assert shape == (14, 434)
    assert axes.get_xlim() == pytest.approx((0, 1.301))
    left, right, bottom, top = axes.images[0].get_extent()
    assert (left, top) == (0, 0)
    assert right == pytest.approx(434 * 3e-3)
    assert bottom == pytest.approx(14 * 3e-3)


@pytest.mark.parametrize("shape", [(1024, 1024), (70, 2000), (2000, 70), (900, 1300)])
def test_single_point_of_contact_survives(shape: tuple[int, int]) -> None:
    pressure = np.zeros(shape)
    where = [(shape[0] // 7, shape[1] // 3), (shape[0] - 1, shape[1] - 1), (3, 5)]
    for point in where:
        pressure[point] = 3 * GIGA
    result = result_of(pressure)
    for axes in maps(plots.pressure(result)):
        values = drawn_array(axes)
        assert values.size < pressure.size
        assert values.count() == len(where)
        assert values.max() == pytest.approx(3)
    (axes,) = maps(plots.contact(result))
    assert np.count_nonzero(shares(axes)[..., 2] > 0.01) == len(where)
    gap = maps(plots.gap(result))[0]
    assert np.count_nonzero(gap.images[1].get_array()[..., 3] > 0.01) == len(where)


def rough(shape: tuple[int, int], missing: NDArray[np.bool_] | None = None) -> ContactResult:
    """Return a contact of many small spots, 11 % of the map, a third of it saturated."""
    field = np.random.default_rng(5).normal(size=shape)
    pressure = np.clip(2.5 * (field - 1.2) * GIGA, 0, 3 * GIGA)
    return result_of(
        pressure if missing is None else np.where(missing, 0.0, pressure), missing=missing
    )


@pytest.mark.long
@pytest.mark.parametrize(("shape", "holes"), [((1300, 1300), False), ((700, 1900), True)])
def test_area_in_image_matches_area(shape: tuple[int, int], holes: bool) -> None:
    # Larger than what is drawn, and with cells at the far edges that reach beyond the map.
    missing = np.zeros(shape, bool)
    missing[100:163, 200:417] = holes
    result = rough(shape, missing)
    touching, saturated = result.contact_fraction, result.saturated_fraction
    lost = missing.mean()
    expected = (1 - touching - lost, touching - saturated, saturated, lost)
    panels = (
        maps(plots.contact(result))[0],
        maps(plots.overview(result))[2],
        maps(plots.comparison([result, result], ["a", "b"]))[2],
    )
    for axes in panels:
        cells = shares(axes)
        assert cells.shape[0] * cells.shape[1] < result.pressure.size / 4
        blocks = [-(-n // m) for n, m in zip(shape, cells.shape[:2], strict=True)]
        points = style.cell_points(shape, (blocks[0], blocks[1]))
        found = (cells * points[..., None]).sum(axis=(0, 1)) / points.sum()
        np.testing.assert_allclose(found, expected, atol=1e-9)
    (axes,) = maps(plots.gap(result))
    closed = axes.images[1].get_array()[..., 3] - style.HALF_A_STEP
    blocks = [-(-n // m) for n, m in zip(shape, closed.shape, strict=True)]
    points = style.cell_points(shape, (blocks[0], blocks[1]))
    assert (closed * points).sum() / points.sum() == pytest.approx(touching + lost, abs=1e-4)


@pytest.mark.long
def test_rendered_image_shows_contact_fraction() -> None:
    result = rough((1210, 1210))
    figure = plots.contact(result)
    (axes,) = maps(figure)
    figure.draw_without_rendering()
    box = axes.get_window_extent().shrunk(0.99, 0.99)
    picture = rendered(figure)
    height = picture.shape[0]
    inside = picture[height - int(box.y1) : height - int(box.y0), int(box.x0) : int(box.x1)]
    ground, elastic, saturated = (
        np.array(mpl.colors.to_rgb(c)) for c in (style.OPEN, style.ELASTIC, style.SATURATED)
    )
    mixing = np.stack([elastic - ground, saturated - ground]).T
    found, *_ = np.linalg.lstsq(mixing, inside.mean(axis=(0, 1)) - ground)
    # The colours are in steps of 1/255, and Matplotlib reduces cells to dots.
    assert found.sum() == pytest.approx(result.contact_fraction, rel=0.06)
    assert found[1] == pytest.approx(result.saturated_fraction, abs=3e-3)


def test_pressure_figure_states_marked_fraction() -> None:
    result = rough((1300, 1300))
    figure = plots.pressure(result)
    (axes,) = maps(figure)
    cells = style.cell_points(result.pressure.shape, (3, 3))
    marked = float(cells[~np.ma.getmaskarray(drawn_array(axes))].sum()) / result.pressure.size
    assert marked > 2 * result.contact_fraction
    assert f"marks {format_percent(marked)} of the figure" in texts(figure)
    assert f"{format_percent(result.contact_fraction)} of the map is in contact" in texts(figure)
    assert "of the figure" not in texts(plots.pressure(result_of(spotted_pressure())))


@pytest.mark.long
@pytest.mark.parametrize("aspect", [0.05, 1.0, 4.0])
def test_maps_have_more_dots_than_cells(aspect: float) -> None:
    shape = (round(60 * aspect), 60)
    result = result_of(
        spotted_pressure((60, 60))[: shape[0]] if aspect <= 1 else np.eye(*shape) * GIGA
    )
    alone = [plots.surface(result.surface), plots.pressure(result), plots.gap(result)]
    panels = [plots.overview(result), plots.comparison([result] * 3, ["a", "b", "c"])]
    for figures, cells in ((alone, style.CELLS_ALONE), (panels, style.CELLS_IN_PANEL)):
        for figure in figures:
            figure.draw_without_rendering()
            for axes in maps(figure):
                box = axes.get_window_extent()
                assert max(box.width, box.height) >= cells


def test_cells_show_fractions_of_classes() -> None:
    pressure = np.zeros((1200, 1200))
    pressure[0, 0], pressure[0, 1] = 3 * GIGA, GIGA
    pressure[600, 600] = GIGA
    figure = plots.contact(result_of(pressure))
    (axes,) = maps(figure)
    cells = shares(axes)
    np.testing.assert_allclose(cells[0, 0], [0.5, 0.25, 0.25, 0], atol=0.01)
    np.testing.assert_allclose(cells[300, 300], [0.75, 0.25, 0, 0], atol=0.01)
    assert np.count_nonzero(cells[..., 0] < 0.99) == 2
    assert "cells of 2 × 2 points" in texts(figure)
    assert "in their shares" in texts(figure)
    assert "cells of" not in texts(plots.contact(result_of(spotted_pressure())))


def test_the_open_gap_of_a_cell_is_that_of_its_open_points() -> None:
    pressure = np.zeros((1200, 1200))
    pressure[0, :2] = GIGA
    result = result_of(pressure)
    (axes,) = maps(plots.gap(result))
    values = drawn_array(axes)
    expected = result.gap[1, :2].mean() * 1e9
    assert values[0, 0] == pytest.approx(expected)
    assert axes.images[1].get_array()[0, 0, 3] == pytest.approx(0.5 + style.HALF_A_STEP)


def test_mean_of_cells_ignores_missing_points() -> None:
    heights = np.arange(24.0).reshape(4, 6)
    heights[0, 0] = np.nan
    heights[2:, 4:] = [[np.nan, np.nan], [1, np.nan]]
    mean = style.cell_mean(heights, (2, 2))
    assert mean[0, 0] == pytest.approx((1 + 6 + 7) / 3)
    assert mean[0, 1] == pytest.approx((2 + 3 + 8 + 9) / 4)
    assert np.isnan(mean[1, 2])
    # The last cells hold one column only.
    odd = style.cell_mean(np.arange(15.0).reshape(3, 5), (2, 2))
    assert odd[1, 2] == 14
    assert odd[0, 2] == pytest.approx((4 + 9) / 2)


def test_contact_legend_gives_the_shares_of_the_points() -> None:
    missing = np.zeros((40, 60), bool)
    missing[0, :12] = True
    figure = plots.contact(result_of(spotted_pressure(), missing=missing))
    (axes,) = maps(figure)
    legend = axes.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == [
        "no contact\n94.50 %",
        "elastic\n4.00 %",
        "saturated\n1.00 %",
        "missing\n0.500 %",
    ]
    assert np.count_nonzero(shares(axes)[..., 3] > 0.99) == 12


def test_pressure_scale_ends_at_the_ceiling_that_is_reached_or_at_the_largest() -> None:
    def top(result: ContactResult, limit: float | None = None) -> Any:
        image = maps(plots.pressure(result, limit))[0].images[0]
        return image.norm.vmax, image.colorbar.extend

    assert top(result_of(spotted_pressure())) == (pytest.approx(3), "neither")
    assert top(result_of(spotted_pressure(), None)) == (pytest.approx(3), "neither")
    assert top(result_of(np.minimum(spotted_pressure(), 2 * GIGA))) == (pytest.approx(2), "neither")
    assert top(result_of(spotted_pressure()), 2.5 * GIGA) == (pytest.approx(2.5), "max")
    # In MPa below 1 GPa.
    assert top(result_of(spotted_pressure()), 0.5 * GIGA) == (pytest.approx(500), "max")


def test_comparison_shares_the_colour_limits() -> None:
    elastic, limited = result_of(10 * spotted_pressure(), None), result_of(spotted_pressure())
    figure = plots.comparison([elastic, limited], ["elastic", "ceiling"])
    first, second = (axes.images[0] for axes in maps(figure)[:2])
    assert first.get_clim() == second.get_clim() == pytest.approx((0, 3))
    assert first.get_array().max() == pytest.approx(30)
    figure = plots.comparison([elastic, limited], ["elastic", "ceiling"], limit=20 * GIGA)
    assert all(axes.images[0].get_clim() == (0, 20) for axes in maps(figure)[:2])
    figure = plots.comparison([elastic, elastic], ["one", "two"])
    assert maps(figure)[0].images[0].get_clim() == pytest.approx((0, 30))


def test_surface_colours_are_robust_and_holes_grey() -> None:
    heights = np.random.default_rng(2).normal(scale=1e-7, size=(100, 100)) + 5e-3
    heights[50, 50] += 1e-4
    heights[:10, :10] = np.nan
    figure = plots.surface(Surface(heights, (1e-6, 1e-6)))
    image = maps(figure)[0].images[0]
    low, high = image.get_clim()
    assert -350 < low < -200
    assert 200 < high < 350
    assert image.colorbar is not None
    assert image.colorbar.extend == "both"
    assert np.ma.getmaskarray(drawn_array(maps(figure)[0])).sum() == 100
    assert mpl.colors.to_hex(image.cmap.get_bad()) == style.MISSING
    assert "missing 1.00 %" in texts(figure)


def test_histogram_integrates_to_the_area_below_the_ceiling() -> None:
    rng = np.random.default_rng(3)
    pressure = np.minimum(np.maximum(rng.normal(1.5, 1.5, (50, 60)), 0) * GIGA, 3 * GIGA)
    limited, elastic = result_of(pressure), result_of(4 * pressure, None)
    for scale in ("linear", "log"):
        figure = plots.pressure_histogram([limited, elastic], ["ceiling", "elastic"], scale)
        stairs = [patch.get_data() for patch in figure.axes[0].patches]
        assert np.array_equal(stairs[0].edges, stairs[1].edges)
        widths = np.diff(np.log10(stairs[0].edges) if scale == "log" else stairs[0].edges)
        share = limited.saturated_fraction / limited.contact_fraction
        assert np.sum(stairs[0].values * widths) == pytest.approx(100 * (1 - share))
        assert np.sum(stairs[1].values * widths) == pytest.approx(100)
        # No bin of the limited contact reaches beyond its ceiling.
        assert np.all(stairs[0].values[stairs[0].edges[1:] > 3 + 1e-9] == 0)
        assert "ceiling 3 GPa" in texts(figure)
        assert f"{format_percent(share)} of it at the 3 GPa ceiling" in texts(figure)


@pytest.mark.parametrize("spike", [20, 100])
@pytest.mark.parametrize("ceiling", [None, 150 * GIGA])
def test_histogram_is_of_the_pressures_that_occur(spike: float, ceiling: float | None) -> None:
    # Nearly full contact with one spike far above: over the whole range nearly all bins are empty.
    rng = np.random.default_rng(3)
    pressure = np.maximum(rng.normal(0.8, 0.12, (80, 90)), 1e-3) * GIGA
    pressure[40, 40] = spike * GIGA
    result = result_of(pressure, ceiling)
    figure = plots.pressure_histogram(result)
    figure.draw_without_rendering()
    (axes,) = figure.axes
    stairs = axes.patches[0].get_data()
    seen = stairs.edges[1:] <= axes.get_xlim()[1]
    assert np.count_nonzero(stairs.values[seen]) > 0.7 * np.count_nonzero(seen) > 15
    # Values beyond the axis are in one more bin and are reported.
    assert np.sum(stairs.values * np.diff(stairs.edges)) == pytest.approx(100)
    assert f"up to {spike} GPa (beyond the axis)" in texts(figure)


def test_histogram_of_few_points_has_few_bins() -> None:
    pressure = np.zeros((20, 20))
    pressure[5:8, 5:9] = np.array([0.2, 0.9, 1.4, 1.6])[np.arange(12) % 4].reshape(3, 4) * GIGA
    stairs = plots.pressure_histogram(result_of(pressure, None)).axes[0].patches[0].get_data()
    assert np.count_nonzero(stairs.values) > 0.5 * stairs.values.size


def test_far_ceiling_does_not_stretch_the_histogram() -> None:
    figure = plots.pressure_histogram(result_of(spotted_pressure() / 100))
    assert figure.axes[0].get_xlim()[1] < 40
    assert "none of it at the 3 GPa ceiling" in texts(figure)


def test_overview_states_the_numbers_that_matter() -> None:
    title = texts(plots.overview(result_of(spotted_pressure())))
    for words in (
        "load 264 mN",
        "contact 5.00 %",
        "saturated 1.00 %",
        "largest pressure 3 GPa",
        "certificate 4.7e-07",
        "regime: saturated at the surface",
    ):
        assert words in title


@pytest.mark.long
def test_failed_solution_is_never_drawn_as_solved() -> None:
    result = result_of(spotted_pressure(), status="stalled")
    for figure in (
        plots.pressure(result),
        plots.contact(result),
        plots.gap(result),
        plots.overview(result),
        plots.pressure_histogram(result),
        plots.comparison([result], ["a"]),
        plots.section(result),
        plots.close_up(result, (12, 24), 8e-6),
        plots.spots(result),
    ):
        assert "NOT CONVERGED" in texts(figure)


def test_unfit_arguments_are_named() -> None:
    result = result_of(spotted_pressure())
    for limit in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(InputError, match="limit must be positive"):
            plots.pressure(result, limit)
    for width in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(InputError, match="width must be positive"):
            plots.section(result, width)
        with pytest.raises(InputError, match="width must be positive"):
            plots.close_up(result, (0, 0), width)
    with pytest.raises(InputError, match="point must be inside the map"):
        plots.close_up(result, (40, 0), 1e-6)
    with pytest.raises(InputError, match="labels"):
        plots.comparison([result], ["a", "b"])
    with pytest.raises(InputError, match="labels"):
        plots.pressure_histogram([result, result], "ab")
    with pytest.raises(InputError, match="results is empty"):
        plots.pressure_histogram([])
    with pytest.raises(InputError, match="scale"):
        plots.pressure_histogram([result], scale="cubic")


@pytest.mark.parametrize(
    ("suffix", "start"),
    [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF"), (".PNG", b"\x89PNG")],
)
def test_save_writes_the_type_of_the_suffix(tmp_path: Path, suffix: str, start: bytes) -> None:
    path = tmp_path / f"figure{suffix}"
    path.write_text("old")
    other = tmp_path / "other name of the same file"
    other.hardlink_to(path)
    plots.save(plots.pressure(result_of(spotted_pressure())), path)
    assert path.read_bytes().startswith(start)
    # Moved into place: writing over the old file would have changed it under both names.
    assert other.read_text() == "old"
    assert set(tmp_path.iterdir()) == {path, other}


@pytest.mark.long
def test_png_matches_savefig_with_one_layout(monkeypatch: pytest.MonkeyPatch) -> None:
    result = result_of(spotted_pressure())
    engine = type(style.layout())
    layouts, execute = [], engine.execute

    def record_layout(self: Any, figure: Figure) -> Any:
        layouts.append(figure)
        return execute(self, figure)

    monkeypatch.setattr(engine, "execute", record_layout)
    for make in (plots.pressure, plots.section):
        figure, same = make(result), make(result)
        # One that is shown elsewhere in another resolution.
        figure.set_dpi(90)
        shown_on = figure.canvas
        layouts.clear()
        picture = export.png(figure)
        assert layouts == [figure]
        assert (figure.canvas, figure.dpi) == (shown_on, 90)
        assert figure.get_layout_engine() is not None
        np.testing.assert_array_equal(imread(io.BytesIO(picture))[..., :3], rendered(same))


def test_a_png_has_an_opacity_only_where_it_is_seen_through() -> None:
    for ground, mode in (("white", "RGB"), ("none", "RGBA")):
        figure = Figure(figsize=(2, 1), facecolor=ground)
        figure.subplots().plot([0, 1])
        assert Image.open(io.BytesIO(export.png(figure))).mode == mode


@pytest.mark.parametrize("name", ["figure.bmp", "figure", "figure.png.txt"])
def test_save_refuses_unknown_suffixes(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"unknown suffix .*; use one of \.png, \.svg, \.pdf"):
        plots.save(Figure(), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_save_refuses_a_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="folder"):
        plots.save(Figure(), tmp_path / "no" / "figure.png")


@pytest.mark.parametrize(
    ("failure", "raised"),
    [
        (OSError(28, "No space left on device"), RoughcontactError),
        (KeyboardInterrupt(), KeyboardInterrupt),
    ],
)
@pytest.mark.parametrize("name", ["figure.png", "figure.svg"])
def test_failed_save_keeps_old_file_only(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    failure: BaseException,
    raised: type[BaseException],
    name: str,
) -> None:
    path = tmp_path / name
    path.write_text("old")

    def half(self: object, stream: Any, *given: Any, **kwargs: Any) -> None:
        stream.write(b"half")
        raise failure

    monkeypatch.setattr(Figure, "savefig", half)
    monkeypatch.setattr(Image.Image, "save", half)
    with pytest.raises(raised):
        plots.save(Figure(), path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_figures_leave_no_global_state() -> None:
    # A fresh interpreter: no pyplot, no chosen backend, no changed setting, and a cheap import.
    code = """
import sys
from roughcontact import plots
from roughcontact.drawing import export, style
from roughcontact.surface import roughness
assert not any(name.split(".")[0] == "matplotlib" for name in sys.modules)
import matplotlib
# Reading the entry "backend" chooses one and imports pyplot.
def settings():
    return {key: matplotlib.rcParams[key] for key in matplotlib.rcParams if key != "backend"}
before = settings()
import io, numpy
from roughcontact.surface.surface import Surface
figure = plots.surface(Surface(numpy.eye(9), (1e-6, 1e-6)))
figure.savefig(io.BytesIO(), format="png")
assert "matplotlib.pyplot" not in sys.modules
assert settings() == before
"""
    # Matplotlib itself may use deprecated functions.
    warn = ["-W", "error", "-W", "ignore::DeprecationWarning"]
    subprocess.run([sys.executable, *warn, "-c", code], check=True, timeout=60)


def test_one_spike_does_not_set_the_scale() -> None:
    # A spike at the ceiling above a broad, lightly loaded plateau.
    heights = np.random.default_rng(3).random((64, 64)) * 1e-9
    heights[0, 0] = 1e-6
    material = Material(young=210e9, poisson=0.3, yield_strength=1e9)
    result = solve(Surface(heights, (1e-6, 1e-6)), load=64 * 64 * 1e-12 * 2e7, material=material)
    assert 0 < result.saturated_fraction < 1e-3
    image = plots.pressure(result).axes[0].images[0]
    assert image.norm.vmax < 0.5 * result.max_pressure


@pytest.mark.long
@pytest.mark.parametrize("shape", [(12, 90), (60, 20)])
def test_titles_and_bars_stay_within_the_figure(shape: tuple[int, int]) -> None:
    missing = np.zeros(shape, bool)
    missing[0, 0] = True
    pressure = np.zeros(shape)
    pressure[4:8, 4:8] = 3 * GIGA
    result = result_of(pressure, missing=missing)
    for figure in (
        plots.surface(result.surface),
        plots.pressure(result),
        plots.contact(result),
        plots.gap(result),
        plots.comparison([result, result], ["a", "b"]),
        plots.close_up(result, (5, 5), 9e-6),
    ):
        figure.draw_without_rendering()
        for axes in figure.axes:
            box = axes.title.get_window_extent()
            assert box.y1 <= figure.bbox.y1 + 1
            for bar in axes.child_axes:
                name = bar.xaxis.label if bar.xaxis.label.get_text() else bar.yaxis.label
                label = name.get_window_extent()
                assert label.x1 <= figure.bbox.x1 + 1
                assert not (axes.title.get_text() and label.overlaps(box.shrunk(1, 0.8)))


def peaked() -> ContactResult:
    """Return a result with its highest peak at (12, 24), inside the spots of `spotted`."""
    result = result_of(spotted_pressure(), pixel=(2e-6, 1e-6))
    heights = result.surface.heights.copy()
    heights[12, 24] = 2e-6
    gap = np.where(result.contact, 0.0, 2e-6 - heights)
    gap[result.saturated] = -3e-8
    surface = Surface(heights, result.surface.pixel)
    return dataclasses.replace(
        result, pair=dataclasses.replace(result.pair, surface=surface), gap=gap
    )


def curve_of(axes: Axes, label: str) -> tuple[Any, Any]:
    (line,) = (line for line in axes.lines if line.get_label() == label)
    return line.get_xdata(), line.get_ydata()


def test_sections_show_the_profile_and_the_pressure_through_the_peak() -> None:
    result = peaked()
    figure = plots.section(result)
    along_x, along_y, pressure_x, pressure_y = figure.axes
    assert along_x.get_title() == "along x, at y = 25 µm"
    assert along_y.get_title() == "along y, at x = 24.5 µm"
    x, before = curve_of(along_x, "before loading, moved by the approach")
    np.testing.assert_allclose(x, np.arange(60) + 0.5)
    np.testing.assert_allclose(before, 1e6 * (result.approach - result.initial_gap[12]), atol=1e-12)
    y, under = curve_of(along_y, "under load")
    np.testing.assert_allclose(y, 2 * (np.arange(40) + 0.5))
    np.testing.assert_allclose(under, -1e6 * result.gap[:, 24], atol=1e-12)
    for axes, line in ((pressure_x, result.pressure[12]), (pressure_y, result.pressure[:, 24])):
        drawn = sum(np.asarray(patch.get_data().values) for patch in axes.patches)
        np.testing.assert_allclose(drawn, line / GIGA)
        assert np.all(axes.lines[0].get_ydata() == 3)
    assert "overlap that flows plastically (saturated)" in texts(figure)
    assert "ceiling" in texts(figure)


def test_sections_are_tilted_as_the_bodies_are() -> None:
    y, x = np.mgrid[-12:12, -20:20] * 1e-6
    surface = Surface(-(x**2 + y**2) / (2 * 1e-3), (1e-6, 1e-6))
    material = Material(210e9, 0.3)
    result = solve(surface, load=0.05, moments=(0.05 * 2e-6, -0.05 * 4e-6), material=material)
    assert abs(result.tilt[1]) > 1e-4
    along_x, along_y, *_ = plots.section(result).axes
    # Elastic displacement never lets the gap shrink below that of the rigid motion.
    for axes in (along_x, along_y):
        _, before = curve_of(axes, "before loading, moved by the approach")
        _, under = curve_of(axes, "under load")
        assert np.all(before - under > 0)
        # Displacements die out away from the contact; a tilt that was left out would not.
        assert before[0] - under[0] < 0.6 * np.max(before - under)
        assert before[-1] - under[-1] < 0.6 * np.max(before - under)


@pytest.mark.long
def test_far_ceilings_and_elastic_contacts_have_no_ceiling_in_the_section() -> None:
    for ceiling in (None, 30 * GIGA):
        figure = plots.section(result_of(spotted_pressure(), ceiling))
        assert "ceiling" not in texts(figure)
        assert "saturated" not in texts(figure)


def test_sections_keep_within_the_map() -> None:
    result = peaked()
    along_x, along_y, *_ = plots.section(result, 10e-6).axes
    assert along_x.get_xlim() == pytest.approx((19, 29))
    assert along_y.get_xlim() == pytest.approx((20, 30))
    heights = result.surface.heights.copy()
    heights[0, 59] = 5e-6
    surface = Surface(heights, result.surface.pixel)
    corner = dataclasses.replace(result, pair=dataclasses.replace(result.pair, surface=surface))
    along_x, along_y, *_ = plots.section(corner, 10e-6).axes
    assert along_x.get_xlim() == pytest.approx((50, 60))
    assert along_y.get_xlim() == pytest.approx((0, 10))
    # Longer than the map: all of it.
    assert plots.section(result, 1.0).axes[1].get_xlim() == pytest.approx((0, 80))


def test_sections_of_two_bodies_are_of_their_sum() -> None:
    result = peaked()
    pair = dataclasses.replace(result.pair, counter_surface=result.surface)
    both = dataclasses.replace(result, pair=pair)
    figure = plots.section(both)
    _, before = curve_of(figure.axes[0], "before loading, moved by the approach")
    heights = 2 * result.surface.heights
    np.testing.assert_allclose(
        before, 1e6 * (both.approach - heights.max() + heights[12]), atol=1e-12
    )
    assert figure.axes[0].get_ylabel() == "sum of heights [µm]"


def test_close_up_shows_the_points_of_its_part() -> None:
    result = peaked()
    left, right = maps(plots.close_up(result, (12, 24), 12e-6))
    np.testing.assert_allclose(drawn_array(left).filled(0), result.pressure[9:15, 18:30] / GIGA)
    assert left.get_xlim() == pytest.approx((18, 30))
    assert left.get_ylim() == pytest.approx((30, 18))
    classes = shares(right).argmax(axis=-1)
    assert classes[3, 6] == 2
    assert classes[2, 6] == 1
    assert classes[0, 0] == 0
    left, _ = maps(plots.close_up(result, (0, 59), 12e-6))
    assert left.get_xlim() == pytest.approx((48, 60))
    assert left.get_ylim() == pytest.approx((12, 0))


def test_bearing_curve_carries_the_areas_of_the_standard() -> None:
    heights = np.random.default_rng(4).gamma(2.0, 1e-7, size=(80, 90))
    surface = Surface(heights, (1e-6, 1e-6))
    figure = plots.bearing_curve(surface)
    (axes,) = figure.axes
    ratio, height = roughness.material_ratio_curve(heights)
    np.testing.assert_allclose(axes.lines[0].get_xdata(), 100 * ratio)
    np.testing.assert_allclose(np.diff(axes.lines[0].get_ydata()), 1e9 * np.diff(height), atol=1e-9)
    core = roughness.core_parameters(ratio, height)
    peaks, dales = (patch.get_path().vertices[:3] for patch in axes.patches)
    # The triangles have the areas of the peaks above and the dales below the core.
    upper = np.interp(core["Smr1"], ratio, height)
    excess = np.maximum(height - upper, 0)
    area = 1e11 * float(np.sum(np.diff(ratio) * (excess[1:] + excess[:-1])) / 2)
    assert np.ptp(peaks[:, 0]) * np.ptp(peaks[:, 1]) / 2 == pytest.approx(area, rel=1e-3)
    assert peaks[0, 1] == pytest.approx(1e9 * upper)
    assert np.ptp(dales[:, 1]) == pytest.approx(1e9 * core["Svk"])
    assert 1e9 * (upper - core["Sk"]) == pytest.approx(dales[0, 1])
    assert f"Smr1 {100 * core['Smr1']:.1f} %" in texts(figure)


def test_spots_are_counted_from_the_largest_down() -> None:
    pressure = np.zeros((20, 40))
    for start, size in ((0, 6), (8, 3), (13, 3), (18, 1), (21, 1), (24, 1)):
        pressure[2, start : start + size] = GIGA
    figure = plots.spots(result_of(pressure))
    (axes,) = figure.axes
    (line,) = (line for line in axes.lines if line.get_marker() == "o")
    np.testing.assert_allclose(line.get_xdata(), [1, 3, 6])
    np.testing.assert_array_equal(line.get_ydata(), [6, 3, 1])
    assert "mean area 2.5 µm²" in texts(figure)
    assert "6 contact spots" in texts(figure)


def curve(
    ceiling: float | None, saturated: list[float], areas: tuple[float, ...] = (1e-11, 1e-10, 1e-9)
) -> LoadCurve:
    loads = (0.01, 0.1, 1.0)
    steps = tuple(
        LoadStep(
            load=load,
            approach=1e-7 * (1 + i),
            contact_area=area,
            perimeter_corrected_area=area,
            saturated_area=area * share,
            max_pressure=GIGA,
            mean_gap=1e-6 / (1 + i),
            stiffness=(0.0, 1e6, np.inf)[i],
            unloading_stiffness=1e6,
            spots=i + 1,
            mean_spot_area=1e-12,
            largest_spot_area=1e-12,
            certificate=1e-7,
            load_error=0.0,
            convolutions=10,
            seconds=0.1,
        )
        for i, (load, area, share) in enumerate(zip(loads, areas, saturated, strict=True))
    )
    return LoadCurve(
        steps=steps,
        control="load",
        nominal_area=1e-8,
        contact_modulus=1e11,
        rms_gradient=0.02,
        ceiling=ceiling,
        boundary="free",
        origins=(Provenance(),),
    )


@pytest.mark.long
def test_load_curve_shows_its_columns_and_laws() -> None:
    elastic = curve(None, [0, 0, 0])
    figure = plots.load_curve(elastic)
    figure.draw_without_rendering()
    areas, lengths, stiffness, number = figure.axes
    # 1e-9 m²/N = κ/(E* h′), hence κ = 2.
    _, law = curve_of(areas, "κ W/(E* h′), κ = 2.00")
    np.testing.assert_allclose(law, [0.1, 1, 10])
    _, shares = curve_of(areas, "contact")
    np.testing.assert_allclose(shares, [0.1, 1, 10])
    _, theory = curve_of(areas, "contact, Persson")
    np.testing.assert_allclose(theory, elastic.persson[0] * 1e10)
    assert "saturated" not in [line.get_label() for line in areas.lines]
    _, approach = curve_of(lengths, "approach")
    np.testing.assert_allclose(approach, [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(stiffness.lines[0].get_ydata(), [np.nan, 1e6, np.nan])
    np.testing.assert_array_equal(number.lines[0].get_ydata(), [1, 2, 3])


@pytest.mark.long
def test_load_curve_with_ceiling_shows_load_over_ceiling() -> None:
    figure = plots.load_curve(curve(GIGA, [0.9, 0.9, 1.0]))
    figure.draw_without_rendering()
    areas = figure.axes[0]
    _, law = curve_of(areas, "load / ceiling")
    np.testing.assert_allclose(law, [0.1, 1, 10])
    _, saturated = curve_of(areas, "saturated")
    np.testing.assert_allclose(saturated, [0.09, 0.9, 10])
    assert "κ" not in texts(figure)
    assert "κ" in texts(plots.load_curve(curve(GIGA, [0, 0, 0])))


@pytest.mark.long
def test_hysteresis_shows_loop_and_energy() -> None:
    heights = np.random.default_rng(3).random((16, 16)) * 1e-7
    material = Material(young=210e9, poisson=0.3, yield_strength=1e9)
    surface = Surface(heights, (1e-6, 1e-6))
    history = load_history(surface, [0.1, 0.2, 0.0, 0.2], material=material)
    figure = plots.hysteresis(history)
    figure.draw_without_rendering()
    loop, bars, total = figure.axes
    assert "shaken down" in texts(figure)
    assert "4 steps" in texts(figure)
    lines = {line.get_label(): line for line in loop.lines}
    # The path starts at first touch; the loads are in mN, two steps indent and two do not.
    through = lines[next(name for name in lines if name.startswith("_"))].get_xydata()
    np.testing.assert_allclose(through[:, 1], [0, 100, 200, 0, 200])
    # From first touch over the first indentation to the second; elastic down and up again.
    for name, dots in (("new indentation", [0, 100, 100, 200]), ("elastic", [0, 200, 200])):
        loads = np.asarray(lines[name].get_ydata())
        np.testing.assert_allclose(loads[np.isfinite(loads)], dots)
    energy = history.column("dissipated_energy")
    heights_of_bars = [patch.get_height() for patch in bars.patches]
    np.testing.assert_allclose(np.array(heights_of_bars) / heights_of_bars[0], energy / energy[0])
    volume = total.lines[0].get_ydata()
    assert volume[-1] == pytest.approx(history.indentation_volume * 1e18)


def test_elastic_path_draws_no_hysteresis() -> None:
    heights = np.random.default_rng(3).random((16, 16)) * 1e-7
    surface = Surface(heights, (1e-6, 1e-6))
    history = load_history(surface, [0.1, 0.04, 0.0, 0.1], material=Material(210e9, 0.3))
    assert history.dissipated_energy == 0
    loop = plots.hysteresis(history).axes[0]
    (line,) = (line for line in loop.lines if line.get_label() == "elastic")
    # One curve, up and down: every load has one approach.
    loads = np.asarray(line.get_ydata())
    assert np.all(np.diff(loads[np.isfinite(loads)]) >= 0)
    np.testing.assert_allclose(loads[np.isfinite(loads)], [0, 0, 40, 100, 100], atol=1e-9)


def test_curves_do_not_connect_positions() -> None:
    heights = np.random.default_rng(3).random((16, 16)) * 1e-7
    surface = Surface(heights, (1e-6, 1e-6))
    aside = Stage(load=0.1, shift=(0.0, 3e-6))
    path = [0.1, aside, 0.1, Stage(load=0.05, shift=(0.0, 3e-6))]
    counter = Surface(np.random.default_rng(4).random((16, 16)) * 1e-7, (1e-6, 1e-6))
    history = load_history(
        surface, path, material=Material(210e9, 0.3), counter_surface=counter, boundary="periodic"
    )
    loop = plots.hysteresis(history).axes[0]
    approach = history.column("approach") * 1e9
    assert abs(approach[0] - approach[1]) > 1
    (line,) = (line for line in loop.lines if line.get_label() == "elastic")
    points = np.asarray(line.get_xydata())
    for one, other in itertools.pairwise(points):
        if np.isfinite([one, other]).all() and one[1] == other[1]:
            assert one[0] == pytest.approx(other[0], rel=1e-6)


@pytest.mark.parametrize("ceiling", [None, GIGA])
def test_theory_does_not_stretch_the_axis_of_areas(ceiling: float | None) -> None:
    # Persson's saturated area falls without end towards small loads.
    one = curve(ceiling, [0, 0, 0.01] if ceiling else [0, 0, 0])
    axes = plots.load_curve(dataclasses.replace(one, rms_gradient=2e-3)).axes[0]
    low, high = axes.get_ylim()
    assert 1e-3 < low <= 0.1
    assert 10 <= high <= 150


@pytest.mark.long
@pytest.mark.parametrize(
    "path",
    [[0.0], [0.1], [Stage(load=0.1, shift=(1e-6, 0.0))], [Stage(load=0.1, shift=(1e-6, 0.0)), 0.0]],
)
def test_hysteresis_of_tiny_loop_is_drawn(path: list[Stage | float]) -> None:
    heights = np.random.default_rng(3).random((16, 16)) * 1e-7
    material = Material(young=210e9, poisson=0.3)
    history = load_history(Surface(heights, (1e-6, 1e-6)), path, material=material)
    plots.hysteresis(history).draw_without_rendering()
