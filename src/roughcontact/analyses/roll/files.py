"""Files of repeated passes.

`save_pvd`: A step is one second of ParaView's time; the volume is part 0 of the series, the
surface part 1.
"""

from __future__ import annotations

import os
from pathlib import Path
from xml.sax.saxutils import quoteattr

from roughcontact._tools.files import require_suffix, write_atomically
from roughcontact.analyses.roll.model import RollingResult
from roughcontact.formats.vtk import save_vtk, save_vtr


def save_pvd(rolling: RollingResult, path: str | os.PathLike[str]) -> None:
    """Write all saved steps of repeated passes as a series for ParaView."""
    require_suffix(path, ".pvd")
    target = Path(path)
    folder = target.with_suffix("")
    lines = []
    for time, (_, _, state) in enumerate(rolling.states(), 1):
        folder.mkdir(exist_ok=True)
        for part, (suffix, save) in enumerate(((".vtr", save_vtr), (".vti", save_vtk))):
            name = f"step-{time:04d}{suffix}"
            save(state, folder / name)
            place = quoteattr(f"{folder.name}/{name}")
            lines.append(f'    <DataSet timestep="{time}" part="{part}" file={place}/>\n')
    write_atomically(
        path,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        f"{''.join(lines)}  </Collection>\n</VTKFile>\n",
    )
