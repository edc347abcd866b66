"""Distributions: of the pressure, of the heights, of the waves of a surface."""

from __future__ import annotations

import html
from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, Range1d, Span

from roughcontact.contact.result import ContactResult
from roughcontact.desk import look
from roughcontact.plots.labels import doubt
from roughcontact.plots.profiles import bearing_parts, histogram_label, linear_bins
from roughcontact.plots.style import NEUTRAL, SERIES, in_unit, prefixed
from roughcontact.surface.spectrum import radial_spectrum
from roughcontact.surface.surface import Surface

# Points of a curve, at most.
_MOST = 1500


class Histogram:
    """How the contact area is spread over the pressure, in the bins of the report's figure."""

    def __init__(self) -> None:
        self.source: Any = ColumnDataSource({name: [] for name in ("left", "right", "density")})
        self.plot: Any = look.chart("Distribution of the contact pressure", x_range=Range1d(0, 1))
        self.plot.y_range.start = 0
        drawn = self.plot.quad(
            left="left", right="right", top="density", bottom=0, source=self.source,
            fill_color=SERIES[0], line_color="white", line_width=0.5,
        )  # fmt: skip
        self._ceiling: Any = Span(
            dimension="height", line_color=NEUTRAL, line_dash="dashed", line_width=1.5,
            visible=False,
        )  # fmt: skip
        self.plot.add_layout(self._ceiling)
        self.root, self.note = look.noted(self.plot)
        self._hover = look.hover(
            self.plot, drawn, [("from", "left"), ("to", "right"), ("density", "density")]
        )

    def clear(self) -> None:
        """Show nothing."""
        self.source.data = {name: [] for name in self.source.data}
        look.put(self.note, "")
        self._ceiling.visible = False

    def show(self, result: ContactResult) -> None:
        """Show the pressures of a result."""
        below = result.pressure[result.contact & ~result.saturated]
        bins = linear_bins([result], [below])
        factor, unit = prefixed(bins.limits[1], "Pa")
        counts, _ = np.histogram(np.clip(below, bins.edges[0], bins.edges[-1]), bins.edges)
        points = max(int(np.count_nonzero(result.contact)), 1)
        widths = np.diff(bins.edges) * factor
        with look.together(self.plot.document):
            self.source.data = {
                "left": bins.edges[:-1] * factor,
                "right": bins.edges[1:] * factor,
                "density": 100 * counts / points / widths,
            }
            first, last = (limit * factor for limit in bins.limits)
            last += 0.03 * (last - first)
            self.plot.x_range.update(start=first, end=last, reset_start=first, reset_end=last)
            self.plot.xaxis.axis_label = f"pressure [{unit}]"
            self.plot.yaxis.axis_label = f"density of contact area [% per {unit}]"
            label = histogram_label(result, "", below, bins.limits, (factor, unit))
            look.put(self.note, html.escape(label))
            self._ceiling.visible = bool(bins.ceilings)
            if bins.ceilings:
                self._ceiling.location = bins.ceilings[0] * factor
            look.hover_units(self._hover, [unit, unit, f"% per {unit}"])
            self.plot.title.text = f"Distribution of the contact pressure{doubt(result)}"


class Bearing:
    """The material ratio curve of a surface, with its core."""

    def __init__(self) -> None:
        self.source: Any = ColumnDataSource({"ratio": [], "height": []})
        self.core: Any = ColumnDataSource({"ratio": [], "height": []})
        self.plot: Any = look.chart("Material ratio curve", x_range=Range1d(0, 100))
        self.plot.xaxis.axis_label = "material ratio [%]"
        drawn = self.plot.line(
            "ratio", "height", source=self.source, line_color=SERIES[0], line_width=2
        )
        self.plot.line(
            "ratio", "height", source=self.core, line_color=NEUTRAL, line_dash="dashed",
            line_width=1.4,
        )  # fmt: skip
        self.root, self.note = look.noted(self.plot)
        self._hover = look.hover(
            self.plot, drawn, [("material ratio", "ratio"), ("height", "height")]
        )

    def clear(self) -> None:
        """Show nothing."""
        for source in (self.source, self.core):
            source.data = {"ratio": [], "height": []}
        look.put(self.note, "")

    def show(self, surface: Surface) -> None:
        """Show the heights of a surface above their mean; missing points are left out."""
        ratio, height, core, upper = bearing_parts(surface)
        scale = factor, unit = prefixed(float(np.abs(height).max()), "m")
        if ratio.size > _MOST:
            kept = np.linspace(0, 1, _MOST)
            ratio, height = kept, np.interp(kept, ratio, height)
        with look.together(self.plot.document):
            self.source.data = {"ratio": 100 * ratio, "height": height * factor}
            ends = np.array([upper, upper - core["Sk"]]) * factor
            self.core.data = {"ratio": np.array([0.0, 100.0]), "height": ends}
            self.plot.yaxis.axis_label = f"height above mean [{unit}]"
            heights = ", ".join(f"{n} {in_unit(core[n], scale, 'm')}" for n in ("Spk", "Sk", "Svk"))
            ratios = ", ".join(f"{name} {100 * core[name]:.1f} %" for name in ("Smr1", "Smr2"))
            look.put(self.note, f"{heights}, {ratios}")
            look.hover_units(self._hover, ["%", unit])


class Spectrum:
    """The radially averaged power spectral density of a surface."""

    def __init__(self) -> None:
        names = ("q", "C", "wavelength")
        self.source: Any = ColumnDataSource({name: [] for name in names})
        self.plot: Any = look.chart("Power spectrum", x_axis_type="log", y_axis_type="log")
        self.plot.xaxis.axis_label = "wave number q [rad/m]"
        self.plot.yaxis.axis_label = "C(q), mean of all directions [m⁴]"
        drawn = self.plot.line("q", "C", source=self.source, line_color=SERIES[0], line_width=1.6)
        self.root, self.note = look.noted(self.plot)
        self._hover = look.hover(
            self.plot, drawn, [("wavelength", "wavelength"), ("q", "q"), ("C", "C")]
        )

    def clear(self) -> None:
        """Show nothing."""
        self.source.data = {name: [] for name in self.source.data}
        look.put(self.note, "")

    def show(self, surface: Surface) -> None:
        """Show the spectrum of a surface; of one with missing points say that it has none."""
        if surface.missing or surface.is_profile:
            self.clear()
            what = "a map" if surface.is_profile else "a map without missing points: fill them"
            look.put(self.note, f"The spectrum needs {what}.")
            return
        q, power, _ = radial_spectrum(surface.heights, surface.pixel)
        there = power > 0
        factor, unit = prefixed(float(2 * np.pi / q.min()), "m")
        with look.together(self.plot.document):
            self.source.data = {
                "q": q[there], "C": power[there], "wavelength": 2 * np.pi / q[there] * factor,
            }  # fmt: skip
            finest = np.pi / max(surface.pixel)
            look.put(self.note, f"Beyond {finest:.3g} rad/m only the corners of the grid count.")
            look.hover_units(self._hover, [unit, "rad/m", "m⁴"])
