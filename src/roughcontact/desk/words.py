"""What the page calls things: one label for each option, messages in the words of the labels."""

from __future__ import annotations

import html
from functools import partial

from roughcontact.errors import Mention, RoughcontactError, parts_of, worded
from roughcontact.request.options import SOLVE, named, offered, text_of

_LABELS = {
    "unit": "Unit of the heights",
    "size": "Sides (y × x)",
    "override-size": "Take these sides though the file tells others",
    "tip-radius": "Tip radius of the probe",
    "points": "Points",
    "crop": "Part to keep (rows, columns)",
    "outliers": "Outliers beyond (standard deviations)",
    "level": "Level",
    "form": "Form to remove",
    "holes": "Missing points",
    "s-filter": "S-filter (shorter waves go)",
    "l-filter": "L-filter (longer waves go)",
    "pixel": "Resample to pixel",
    "rotate": "Rotate",
    "load": "Load",
    "hertz": "Hertz pressure of the smooth bodies",
    "approach": "Approach",
    "load-point": "Load acts at (y, x)",
    "young": "Young's modulus",
    "poisson": "Poisson's ratio",
    "yield-strength": "Yield strength",
    "counter-material": "Material of the counter-body",
    "counter-young": "Young's modulus of it",
    "counter-poisson": "Poisson's ratio of it",
    "counter-yield-strength": "Yield strength of it",
    "body": "Nominal form under the roughness",
    "counter-body": "Form of the counter-body",
    "counter-surface": "Map of the counter-body",
    "align": "Bring both maps to one grid",
    "offset": "Shift of the counter-map (y, x)",
    "angle": "Turn of the counter-map",
    "mirror": "Mirror the counter-map",
    "ceiling": "Pressure ceiling",
    "boundary": "What the map is",
    "max-iterations": "Most convolutions",
}


def label(name: str) -> str:
    """Return what the page calls an option."""
    return _LABELS.get(name, name.replace("-", " ").capitalize())


def spell(mention: Mention, task: str = SOLVE) -> str:
    """Return an argument in the words of the page: its label, and the text to give."""
    if mention.name == "file":
        return "the map"
    name = named(mention.name, task)
    if name is None:
        return str(mention)
    if mention.value is None or mention.value is True:
        return f"“{label(name)}”"
    return f"“{label(name)}” {text_of(mention.value, offered(task)[name])}"


def told(error: RoughcontactError, task: str = SOLVE) -> str:
    """Return what an error says, in the words of the page."""
    return error.worded(partial(spell, task=task))


def spelled(text: str, task: str = SOLVE) -> str:
    """Return a sentence of the library in the words of the page."""
    return worded(parts_of(text), partial(spell, task=task))


def escaped(text: str) -> str:
    """Return text that is never markup."""
    return html.escape(text)
