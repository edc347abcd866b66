"""Many loads and many grids: a load curve, a load history, a study of the resolution."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from bokeh.layouts import gridplot
from bokeh.models import Column, ColumnDataSource, FactorRange, Span
from bokeh.transform import dodge

from roughcontact.contact.curve import LoadCurve
from roughcontact.contact.history import LoadHistory
from roughcontact.contact.study import ResolutionStudy
from roughcontact.desk import look
from roughcontact.desk.headline import table
from roughcontact.desk.words import escaped
from roughcontact.plots.curves import branches, states
from roughcontact.plots.style import ELASTIC, NEUTRAL, SATURATED, SERIES, prefixed
from roughcontact.report.quantities import listing_of
from roughcontact.report.studied import STUDY_COLUMNS
from roughcontact.report.tables import CURVE_COLUMNS, HISTORY_COLUMNS


class Curve:
    """A load curve: areas, gap and stiffness over the load, and where the load is now."""

    def __init__(self) -> None:
        names = ("load", "contact", "saturated", "gap", "approach", "stiffness")
        self.source: Any = ColumnDataSource({name: [] for name in names})
        self.now: Any = Span(
            dimension="height", line_color=NEUTRAL, line_width=1.5, line_dash="dashed",
            visible=False,
        )  # fmt: skip
        self._load, self._factor = math.nan, 1.0
        log: dict[str, Any] = {"x_axis_type": "log"}
        self.area = look.chart("Contact and saturated area", y_axis_type="log", **log)
        self.lengths = look.chart("Approach and mean gap", x_range=self.area.x_range, **log)
        self.stiffness = look.chart(
            "Contact stiffness", y_axis_type="log", x_range=self.area.x_range, **log
        )
        for plot, name, colour, label in (
            (self.area, "contact", SERIES[0], "contact"),
            (self.area, "saturated", SATURATED, "saturated"),
            (self.lengths, "approach", SERIES[0], "approach"),
            (self.lengths, "gap", SERIES[1], "mean gap"),
            (self.stiffness, "stiffness", SERIES[0], "stiffness"),
        ):
            where = {"source": self.source, "legend_label": label, "color": colour}
            plot.line("load", name, line_width=1.6, **where)
            plot.scatter("load", name, size=6, **where)
        self.plots = (self.area, self.lengths, self.stiffness)
        for plot in self.plots:
            look.quiet_legend(plot)
            plot.add_layout(self.now)
        self.area.yaxis.axis_label = "share of the map [%]"
        self.table: Any = look.markup(sizing_mode="stretch_width", margin=(4, 8))
        grid = gridplot(
            [[self.area, self.lengths], [self.stiffness, None]], merge_tools=True,
            toolbar_location="above", sizing_mode="stretch_width", toolbar_options={"logo": None},
        )  # fmt: skip
        grid.cols = "minmax(0, 1fr)"
        self.root = Column(grid, self.table, sizing_mode="stretch_width")

    def clear(self) -> None:
        """Show nothing."""
        self.source.data = {name: [] for name in self.source.data}
        look.put(self.table, "")

    def show(self, curve: LoadCurve) -> None:
        """Show a load curve."""
        load = curve.column("load")
        unit = "N/m" if curve.is_profile else "N"
        self._factor, shown = prefixed(float(load.max()), unit)
        lengths = np.concatenate([curve.column("approach"), curve.column("mean_gap")])
        scale, length_unit = prefixed(float(lengths.max()), "m")
        stiffness = curve.column("stiffness")
        # Nothing but saturated pixels has none, full periodic contact has no bound.
        stiffness[~(np.isfinite(stiffness) & (stiffness > 0))] = np.nan
        stiff, stiffness_unit = prefixed(float(np.nanmax(stiffness, initial=0.0)), f"{unit}/m")
        shares = (100 * curve.column(f"{name}_area") / curve.nominal_area
                  for name in ("contact", "saturated"))  # fmt: skip
        contact, saturated = (np.where(share > 0, share, np.nan) for share in shares)
        with look.together(self.area.document):
            self.source.data = {
                "load": load * self._factor, "contact": contact, "saturated": saturated,
                "gap": curve.column("mean_gap") * scale,
                "approach": curve.column("approach") * scale, "stiffness": stiffness * stiff,
            }  # fmt: skip
            for plot in self.plots:
                plot.xaxis.axis_label = f"load [{shown}]"
            self.lengths.yaxis.axis_label = f"length [{length_unit}]"
            self.stiffness.yaxis.axis_label = f"stiffness dW/dω [{stiffness_unit}]"
            heads, rows = listing_of(CURVE_COLUMNS, curve, brief=True)
            look.put(self.table, table(rows, heads))
            self.mark(self._load)

    def mark(self, load: float) -> None:
        """Mark the load that is worked with [N]."""
        self._load = load
        self.now.visible = load > 0
        if load > 0:
            self.now.location = load * self._factor


class History:
    """A load history: load over approach, and what each step dissipates."""

    def __init__(self) -> None:
        self.points: Any = ColumnDataSource({"approach": [], "load": []})
        self.lines: Any = ColumnDataSource({"approach": [], "load": [], "kind": [], "colour": []})
        self.bars: Any = ColumnDataSource({"step": [], "energy": []})
        self.loop = look.chart("Load history", height=300)
        self.loop.multi_line(
            "approach", "load", source=self.lines, line_color="colour", line_width=2,
            legend_field="kind",
        )  # fmt: skip
        self.loop.scatter("approach", "load", source=self.points, size=5, color=NEUTRAL)
        look.quiet_legend(self.loop)
        self.energy = look.chart("Dissipated energy", height=300)
        self.energy.vbar(
            "step", top="energy", width=0.7, source=self.bars, color=SATURATED, line_color=None
        )
        self.energy.xaxis.axis_label = "step"
        # There is no step one and a half.
        self.energy.xaxis.ticker.min_interval = 1
        self.energy.xaxis.ticker.num_minor_ticks = 0
        self.energy.y_range.start = 0
        self.table: Any = look.markup(sizing_mode="stretch_width", margin=(4, 8))
        grid = gridplot(
            [[self.loop, self.energy]], merge_tools=True, toolbar_location="above",
            sizing_mode="stretch_width", toolbar_options={"logo": None},
        )  # fmt: skip
        grid.cols = "minmax(0, 1fr)"
        self.root = Column(grid, self.table, sizing_mode="stretch_width")

    def clear(self) -> None:
        """Show nothing."""
        for source in (self.points, self.lines, self.bars):
            source.data = {name: [] for name in source.data}
        look.put(self.table, "")

    def show(self, history: LoadHistory) -> None:
        """Show a load history."""
        found = states(history)
        approach, load = (np.array([getattr(one, name) for one in found])
                          for name in ("approach", "load"))  # fmt: skip
        across, unit_across = prefixed(float(np.abs(approach).max()), "m")
        up, unit_up = prefixed(float(load.max()), "N")
        energy = history.column("dissipated_energy")
        scale, unit = prefixed(float(energy.max()), "J")
        colours = {"elastic": ELASTIC, "new indentation": SATURATED}
        lines = [(kind, branch) for kind, all_of in branches(found).items() for branch in all_of]
        with look.together(self.loop.document):
            self.points.data = {"approach": approach * across, "load": load * up}
            self.lines.data = {
                "approach": [[one.approach * across for one in branch] for _, branch in lines],
                "load": [[one.load * up for one in branch] for _, branch in lines],
                "kind": [kind for kind, _ in lines],
                "colour": [colours[kind] for kind, _ in lines],
            }
            self.bars.data = {"step": np.arange(1, energy.size + 1), "energy": energy * scale}
            self.loop.xaxis.axis_label = f"approach from first touch [{unit_across}]"
            self.loop.yaxis.axis_label = f"load [{unit_up}]"
            self.energy.yaxis.axis_label = f"dissipated energy [{unit}]"
            heads, rows = listing_of(HISTORY_COLUMNS, history)
            look.put(self.table, table(rows, heads))


class Study:
    """A study of the resolution: contact on each grid, and what that means."""

    def __init__(self) -> None:
        self.source: Any = ColumnDataSource({"case": [], "contact": [], "saturated": []})
        self.plot = look.chart("Contact on other grids", x_range=FactorRange(), height=240)
        for name, colour, place in (("contact", ELASTIC, -0.18), ("saturated", SATURATED, 0.18)):
            self.plot.vbar(
                dodge("case", place, range=self.plot.x_range), top=name, width=0.32,
                source=self.source, color=colour, line_color=None, legend_label=name,
            )  # fmt: skip
        look.quiet_legend(self.plot)
        self.plot.yaxis.axis_label = "share of the map [%]"
        self.plot.y_range.start = 0
        self.plot.xaxis.major_label_orientation = 0.6
        self.table: Any = look.markup(sizing_mode="stretch_width", margin=(4, 8))
        self.root = Column(self.plot, self.table, sizing_mode="stretch_width")

    def clear(self) -> None:
        """Show nothing."""
        self.source.data = {name: [] for name in self.source.data}
        self.plot.x_range.factors = []
        look.put(self.table, "")

    def show(self, study: ResolutionStudy) -> None:
        """Show a study."""
        cases = study.named()
        names = [name for name, _ in cases]
        with look.together(self.plot.document):
            self.plot.x_range.factors = names
            self.source.data = {
                "case": names,
                "contact": [100 * case.contact_fraction for _, case in cases],
                "saturated": [100 * case.saturated_fraction for _, case in cases],
            }
            heads, rows = listing_of(STUDY_COLUMNS, study)
            said = "".join(f"<p>{escaped(text)}</p>" for text in study.sentences)
            look.put(self.table, said + table(rows, heads))
