"""What the page calls things: messages in the words of the labels."""

from __future__ import annotations

import html
from functools import partial

from roughcontact.errors import Mention, RoughcontactError, parts_of, worded
from roughcontact.request.solve import TASK as SOLVE
from roughcontact.request.task import Command


def spell(mention: Mention, task: Command = SOLVE) -> str:
    """Return an argument in the words of the page: its label, and the text to give."""
    if mention.name == "file":
        return "the map"
    option = task.named(mention.name)
    if option is None:
        return str(mention)
    if mention.value is None or mention.value is True:
        return f"“{option.label}”"
    return f"“{option.label}” {option.text(mention.value)}"


def told(error: RoughcontactError, task: Command = SOLVE) -> str:
    """Return what an error says, in the words of the page."""
    return error.worded(partial(spell, task=task))


def spelled(text: str, task: Command = SOLVE) -> str:
    """Return a sentence of the library in the words of the page."""
    return worded(parts_of(text), partial(spell, task=task))


def escaped(text: str) -> str:
    """Return text that is never markup."""
    return html.escape(text)
