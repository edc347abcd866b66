"""Where a map came from and what was done to it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Provenance:
    """Where a map came from and what was done to it.

    Parameters
    ----------
    source : str
        File name, or how the map was made; empty if unknown.
    instrument : str
        Instrument or file format as the file names it; empty if unknown.
    channel : str
        Height channel that was read; empty if there is only one.
    steps : tuple of str
        Preparation steps in their order, each one sentence.
    """

    source: str = ""
    instrument: str = ""
    channel: str = ""
    steps: tuple[str, ...] = ()
