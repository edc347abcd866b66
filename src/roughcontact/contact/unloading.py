"""What a contact leaves behind for unloading and the next loading."""

from __future__ import annotations

from roughcontact.arguments import checked
from roughcontact.contact.facing import indented
from roughcontact.contact.result import ContactResult
from roughcontact.surface.surface import Surface


@checked
def indented_surface(result: ContactResult) -> Surface:
    """Return the surface of a contact with the permanent indentation that the contact leaves.

    Parameters
    ----------
    result : ContactResult
        A solution.

    Returns
    -------
    Surface
        Heights less `ContactResult.residual_indentation`; the surface itself where nothing is
        saturated. Pressed under smaller loads it is elastic: unloading and loading again follow
        `roughcontact.contact.load_history`. All of the indentation is on the surface, whichever
        body is softer, which changes no contact of the two at this position.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> rough = rc.Surface(*rc.reference_map(32))
    >>> loaded = rc.solve(rough, material=steel, load=1.0)
    >>> again = rc.solve(rc.indented_surface(loaded), material=steel, load=1.0)
    >>> loaded.saturated_fraction > 0, round(again.contact_area / loaded.contact_area, 2)
    (True, 1.0)
    """
    return indented(result.surface, result.residual_indentation)
