"""How the page looks: one sheet, no fonts and nothing else from elsewhere."""

from __future__ import annotations

from typing import Any

INK, QUIET, LINE, GROUND, ACCENT = "#1f2328", "#59636e", "#d8dee4", "#f6f8fa", "#1f6feb"
WARNING, CAUTION = "#b42318", "#8a5a00"
SIDE = 336
"""Width of the column of controls."""

FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif'

TEXT = f"""
:host {{ font-family: {FONT}; font-size: 13px; color: {INK}; }}
.bk-input, .bk-btn, label, .bk-input-group {{ font-family: {FONT}; font-size: 13px; }}
.bk-input {{ border-radius: 5px; border-color: {LINE}; }}
.bk-input:focus {{ border-color: {ACCENT}; outline: 2px solid {ACCENT}33; }}
.wrong, :host(.wrong) {{ color: {WARNING}; font-size: 12px; }}
h1 {{ font-size: 16px; margin: 6px 14px 0 0; font-weight: 600; }}
h2 {{ font-size: 12px; margin: 0 0 4px; font-weight: 600; color: {QUIET};
  text-transform: uppercase; letter-spacing: .05em; }}
p {{ margin: 0 0 6px; }}
.quiet {{ color: {QUIET}; }}
progress {{ height: 6px; }}
.fold {{ font-size: 13px; color: {ACCENT}; }}
.numbers {{ display: flex; flex-wrap: wrap; gap: 4px 22px; }}
.numbers div {{ display: flex; flex-direction: column; }}
.numbers dt {{ color: {QUIET}; font-size: 11px; }}
.numbers dd {{ margin: 0; font-size: 15px; font-weight: 600; font-variant-numeric: tabular-nums; }}
table {{ border-collapse: collapse; font-variant-numeric: tabular-nums; }}
td, th {{ padding: 2px 12px 2px 0; text-align: left; vertical-align: top; font-weight: 400; }}
th {{ color: {QUIET}; }}
tr + tr td {{ border-top: 1px solid {LINE}; }}
ul.cautions {{ margin: 0; padding: 0; list-style: none; max-height: 78px; overflow-y: auto; }}
ul.cautions li {{ margin: 0 0 2px; padding-left: 8px; border-left: 3px solid {LINE}; }}
ul.cautions li.warning {{ border-color: {WARNING}; }}
ul.cautions li.caution {{ border-color: {CAUTION}; }}
ul.cautions b {{ font-weight: 600; }}
.good {{ color: #1a7f37; }} .bad {{ color: {WARNING}; }}
pre {{ background: {GROUND}; border: 1px solid {LINE}; border-radius: 5px; padding: 8px;
  overflow-x: auto; font-size: 12px; white-space: pre-wrap; }}
"""

FOLD = f"""
:host(.card) {{ border: 0 !important; border-radius: 0 !important; box-shadow: none !important;
  outline: none; background: white; }}
.card-header {{ padding: 2px 0 !important; border: 0 !important; min-height: 0 !important;
  background: transparent !important; cursor: pointer; }}
.card-header:focus-visible {{ outline: 2px solid {ACCENT}; }}
"""

OLD = {"opacity": "0.4"}
"""How results look that answer another request than the last."""

SECTION = {"border-top": f"1px solid {LINE}", "padding-top": "8px"}
SHEETS: dict[str, Any] = {"stylesheets": [TEXT]}
SHEET: dict[str, Any] = {"stylesheets": [TEXT], "margin": (0, 0)}
BLOCK: dict[str, Any] = {"sizing_mode": "stretch_width", "margin": (0, 0, 4, 0)}
CONTROL: dict[str, Any] = {
    "stylesheets": [TEXT], "sizing_mode": "stretch_width", "margin": (0, 0, 4, 0),
}  # fmt: skip
WIDE: dict[str, Any] = {
    "stylesheets": [TEXT], "sizing_mode": "stretch_width", "margin": (0, 0, 6, 0),
}  # fmt: skip
TABS: dict[str, Any] = {"stylesheets": [TEXT], "sizing_mode": "stretch_both", "margin": (4, 0)}
STRIP: dict[str, Any] = {"sizing_mode": "stretch_width", "margin": (0, 0, 6, 0)}
BUTTON: dict[str, Any] = {"stylesheets": [TEXT], "margin": (0, 6, 4, 0)}
