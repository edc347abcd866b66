"""Steps of repeated passes as a series that ParaView plays."""

from __future__ import annotations

import os
from pathlib import Path
from xml.sax.saxutils import quoteattr

from roughcontact.files import require_suffix, write
from roughcontact.formats import vtk
from roughcontact.volume.rolling import Rolling


def save_pvd(rolling: Rolling, path: str | os.PathLike[str]) -> None:
    """Write every step that is kept of repeated passes as a series for ParaView.

    Parameters
    ----------
    rolling : Rolling
        Passes with a ``folder``.
    path : str or path
        File to write; it must end in ``.pvd``. The steps go into a folder beside it, of the same
        name without the suffix: ``step-0001.vtr``, the volume, and ``step-0001.vti``, the maps of
        its surface; see `vtk.save_vtr` and `vtk.save_vtk`. The file itself, which names them,
        comes last.

    Raises
    ------
    InputError
        If the suffix is another, or the passes have no folder.
    OSError
        If a file cannot be written.

    Notes
    -----
    A step is a second of ParaView's time; the volume is part 0 of the series, the surface part 1.
    """
    require_suffix(path, ".pvd")
    target = Path(path)
    folder = target.with_suffix("")
    lines = []
    for time, (_, _, state) in enumerate(rolling.states(), 1):
        folder.mkdir(exist_ok=True)
        for part, (suffix, save) in enumerate(((".vtr", vtk.save_vtr), (".vti", vtk.save_vtk))):
            name = f"step-{time:04d}{suffix}"
            save(state, folder / name)
            place = quoteattr(f"{folder.name}/{name}")
            lines.append(f'    <DataSet timestep="{time}" part="{part}" file={place}/>\n')
    write(
        path,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        f"{''.join(lines)}  </Collection>\n</VTKFile>\n",
    )
