"""File formats of interface laws."""

from __future__ import annotations

from roughcontact.formats.export import Content, FormatTable, lazy_writer

_SAVE = lazy_writer("analyses.law.decks:save")

LAW_FORMATS = FormatTable(
    "the law of an interface",
    {
        suffix: Content(words, _SAVE)
        for suffix, words in {
            ".npz": "arrays",
            ".csv": "thinned tables",
            ".json": "numbers",
            ".inp": "a deck for Abaqus",
            ".ccx": "a deck for CalculiX",
            ".mac": "real constants for Ansys APDL",
            ".i": "functions for MOOSE",
            ".txt": "a table for mixed lubrication",
        }.items()
    },
)
