"""A report on repeated passes: that on their last state, with the passes first."""

from __future__ import annotations

import datetime
import os
from typing import Any

from roughcontact.errors import Spell
from roughcontact.files import write
from roughcontact.report import chapters, page, results, rolled, sources, volume
from roughcontact.report.page import Chapter, Table, sentence
from roughcontact.units import engineering
from roughcontact.volume.rolling import Rolling


def render(
    rolling: Rolling,
    *,
    command: str = "",
    date: datetime.date | None = None,
    spell: Spell = str,
    processes: int = 1,
) -> str:
    """Return a report as the text of an HTML file.

    Parameters
    ----------
    rolling : Rolling
        What the report is on.
    command, date, spell, processes
        As for `roughcontact.report.volume.render`.

    Returns
    -------
    str
        HTML with its figures inside.
    """
    lead = volume.Lead(
        _title(rolling),
        chapters.headlines(rolling, rolled.HEADLINES),
        _of(rolling),
        sources.of(rolling),
        rolling.cautions,
        ("steps, pixel and direction of the passes",),
    )
    return volume.render(
        rolling.result, lead=lead, command=command, date=date, spell=spell, processes=processes
    )


def save(rolling: Rolling, path: str | os.PathLike[str], **options: Any) -> None:
    """Write a report to an HTML file.

    Parameters
    ----------
    rolling : Rolling
        What the report is on.
    path : str or path
        File to write, ``.html`` or ``.htm``; it appears only once it is complete, and a file
        that was there stays as it was until then.
    **options
        As for `render`.

    Raises
    ------
    InputError
        If the suffix is another one, or the folder does not exist.
    OSError
        If the file cannot be written.
    """
    page.check_path(path)
    write(path, render(rolling, **options))


def _title(rolling: Rolling) -> str:
    name = rolling.result.solution.surface.provenance.source or "an unnamed surface"
    load = engineering(rolling.result.solution.load, "N")
    return f"{rolled.counted(rolling)} over {name} under {load}"


def _of(rolling: Rolling) -> Chapter:
    chapter = Chapter("Passes")
    chapter.add(
        "text", f"{sentence(f'the passes come to: {rolling.answer}')} {rolled.criterion(rolling)}"
    )
    chapter.add("table", chapters.quantities(results.rows(rolling)))
    head, rows = results.listing(rolling)
    chapter.add("table", Table(rows, head))
    chapters.show(chapter, rolled.FIGURES, rolling)
    return chapter
