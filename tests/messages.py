"""Rules of messages: one or two short sentences."""

from __future__ import annotations

from roughcontact.cautions import Caution
from roughcontact.errors import render_message

MAX_WORDS = 20


def fault(caution: Caution) -> str:
    """Return the error in the text of a message, empty if there is none."""
    text = render_message(caution.parts)
    if len(text.split()) > MAX_WORDS:
        return f"{len(text.split())} words: {text}"
    if text[:1].islower() or not text.endswith("."):
        return f"no sentence: {text}"
    if ";" in text or text.count(":") > 1:
        return f"several clauses: {text}"
    return ""
