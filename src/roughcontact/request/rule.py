"""What options ask of each other, as data."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

from roughcontact.errors import InputError, Mention
from roughcontact.request.option import Option


class Demand(Enum):
    """What a rule asks of its options."""

    NEEDED = auto()
    NEEDS = auto()
    EXCLUDES = auto()
    ONE_OF = auto()
    ANY_OF = auto()


NEEDED, NEEDS, EXCLUDES, ONE_OF, ANY_OF = Demand


@dataclass(frozen=True, init=False)
class Rule:
    """What some options ask of each other.

    Parameters
    ----------
    demand : Demand
        ``NEEDED``: the first is given; ``NEEDS``: the first only with one of the others;
        ``EXCLUDES``: the first with none of the others; ``ONE_OF``: exactly one is given;
        ``ANY_OF``: one or more are.
    *options : Option
        Of which it speaks.
    value : str
        Of a ``NEEDS``: what the other has to be.
    text : str
        What to give, or an example of it.
    """

    demand: Demand
    options: tuple[Option[Any], ...]
    value: str = ""
    text: str = ""

    def __init__(self, demand: Demand, *options: Option[Any], **more: str) -> None:
        for name, held in {"demand": demand, "options": options, **more}.items():
            object.__setattr__(self, name, held)


def check(rules: Iterable[Rule], request: Any) -> None:
    """Raise `InputError` for the first rule that a request breaks."""
    for rule in rules:
        first, *others = rule.options
        about = first.argument
        given = [option for option in rule.options if request.is_given(option)]
        if rule.demand is NEEDED and not given:
            raise InputError(f"is needed: {rule.text}", argument=about)
        if rule.demand is ONE_OF and len(given) != 1:
            raise InputError(
                "give one of ", *listed(rule.options, " and "), ", and no more than one, such as ",
                Mention(about, rule.text),
            )  # fmt: skip
        if rule.demand is ANY_OF and not given:
            raise InputError("nothing is asked: give ", *listed(rule.options, " or "))
        if rule.demand is NEEDS and rule.value:
            if first in given and request.get(others[0]) != rule.value:
                needed = Mention(others[0].argument, rule.value)
                raise InputError("needs ", needed, argument=about)
        elif rule.demand is NEEDS and given == [first]:
            raise InputError("needs ", *listed(others, " or "), argument=about)
        if rule.demand is EXCLUDES and first in given and given != [first]:
            raise InputError("goes without ", *listed(others, " and "), argument=about)


def listed(options: Iterable[Option[Any]], last: str) -> list[Any]:
    """Return mentions of options with commas between them, and a word before the last."""
    mentions: list[Any] = [Mention(option.argument) for option in options]
    parts = [part for mention in mentions for part in (mention, ", ")][:-1]
    if len(mentions) > 1:
        parts[-2] = last
    return parts
