"""An estimate asked for in words, told and written."""

from __future__ import annotations

from pathlib import Path

from roughcontact.errors import InputError
from roughcontact.joint.estimate import Estimate, estimate
from roughcontact.request import outputs
from roughcontact.request.maps import surfaces
from roughcontact.request.options import ESTIMATE, Given
from roughcontact.request.outputs import Say
from roughcontact.request.request import from_text

_PARAMETERS = ("Sq", "Sdq", "Sal", "Str", "Ssk", "Sku")


def estimated(file: Path | None, given: Given, say: Say) -> tuple[Estimate, list[Path]]:
    """Return the estimate that options ask for, and the files that it was written to.

    Parameters
    ----------
    file : Path, optional
        A measured map.
    given : Mapping
        Options of `ESTIMATE` as text, by name.
    say : callable
        Called with a few words before every stage.

    Raises
    ------
    RoughcontactError
        If an option cannot be used, or the contact lies outside the domain of the formulas.
    """
    request = from_text(ESTIMATE, file, given)
    request.check_places()
    if request["pressure"] is None:
        raise InputError("is needed: load over nominal area, such as '20 MPa'", argument="pressure")
    material, counter_material = request.bodies()
    maps = [] if file is None else surfaces(request, say)
    try:
        found = estimate(
            maps[0] if maps else None,
            pressure=request["pressure"],
            material=material,
            counter_material=counter_material,
            ceiling=request["ceiling"],
            **{name: request[name.lower()] for name in _PARAMETERS},
        )
    except InputError as error:
        if maps and error.argument in _PARAMETERS and request[error.argument.lower()] is None:
            # Nobody gave it: it is the map's.
            raise InputError(f"{file} ", *error.parts) from None
        raise
    return found, outputs.write([(path, found.save) for path in request.outputs], say)
