"""File formats of repeated passes."""

from __future__ import annotations

from roughcontact.formats.export import VTI, VTR, Content, FormatTable, Writer, lazy_writer


def _last_state_writer(write: Writer) -> Writer:
    """Return a writer of the state after the last pass."""
    return lambda rolling, path: write(rolling.result, path)


ROLLING_FORMATS = FormatTable(
    "repeated passes",
    {
        ".nc": Content("everything", lazy_writer("analyses.roll.model:save_rolling")),
        ".vtr": Content("final strain and stress", _last_state_writer(VTR)),
        ".vti": Content("final maps", _last_state_writer(VTI)),
        ".pvd": Content(
            "all steps of --folder for ParaView", lazy_writer("analyses.roll.model:save_pvd")
        ),
    },
)
