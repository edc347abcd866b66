"""What users read is plain English in US spelling, and short."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import roughcontact as rc
from roughcontact.request.tasks import COMMANDS, GROUPS

ROOT = Path(__file__).parents[1]
SOURCE = Path(rc.__file__).parent
PAGES = sorted([*(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "howto").glob("*.md")])
USER_PAGES = [ROOT / "README.md", *PAGES]

# Expression -> what to write instead.
BANNED = {
    r"hangs? (on|together)": "depends on",
    r"told|tells?": "shows, reports, given",
    r"(asks?|asked) (for|of)|what is asked": "the request",
    r"lies? (at|within|in|on)": "is at, is within",
    r"goes with(out)?": "is proportional to; needs, excludes",
    r"(goes|go) on": "continues, resumes",
    r"tak(e|es|en|ing) (away|out)": "download; remove",
    r"ways? leads? through": "an open path crosses the map",
    r"bring a map": "open or upload a map",
    r"how sure|less sure|surer": "uncertainty, interval",
    r"or beyond": "the error source that is not studied",
    r"not (bounded|known)|is known of": "no interval",
    r"beside": "versus, compared with; besides",
    r"as (it is|they are|they stand)(?= [,.;:]|[,.;:])": "unchanged",
    r"afresh|anew|once more": "again",
    r"to and fro|there and back": "reciprocating; forward and backward",
    r"round and round": "continuously in one direction",
    r"there are none|none left": "no …",
    r"(of )?per cents?": "percent",
    r"in the (beginning|end)": "first; finally",
    r"(dealt|shared) out": "distributed",
    r"falls? (into|apart)": "consists of",
    r"in (plain )?words|worded|the words of": "text, formatted, terms",
    r"when one waits|who looks": "progress; the user",
    r"(a|each|this) work(?! of)": "project",
    r"never mind": "no effect while …",
    r"of (its|their) own|of the resolution of": "separate; resolution-dependent",
    r"turn(s|ed) the question|question is turned": "inverse problem",
    r"refuses what|what is refused": "rejects input outside …",
    r"some \d[\d ]*": "about",
    r"as many as|so many|so much": "the number of",
    r"the least|least depth": "smallest, shallowest",
    r"bears?|borne": "carries the load",
    r"(has|have) flowed|(metal|steel|summits?|spots?|roughness) flows?": "yields",
    r"leaks? (little|more)|what leaks|more leaks": "the leak rate is low or higher",
    r"come closer": "the approach increases",
    r"feels?|felt": "affects",
    r"(knows|know) (no|nothing|not)|does not know": "does not include",
    r"stands? (in )?for": "represents, approximates",
    r"stands? (in|there|below|at)": "is listed, is in",
    r"at odds": "differs from, contradicts",
    r"honed less ground": "honed − ground",
    r"excludes zero": "significant (95 %)",
    r"passed between": "bracket: A to B",
    r"looked (at|for)": "checks passed",
    r"what (one sees|draws)": "name the thing",
    r"(rows?|steps?|bytes?|spots?|waves?) a (load|pass|point|map|pixel|cell|side)": "per",
    r"(the )?(former|latter)|respectively": "repeat the noun",
    r"please|simply|just|obviously": "(delete)",
    r"of (that|those) of": "a noun compound",
    r"imprints?|dents?": "residual indentation",
    r"touching area": "real contact area",
    r"kept (by|in|apart)": "cached, saved",
    r"not (yet )?tried": "not studied",
    r"whole map": "nominal area",
}  # fmt: skip
COLON_LOGIC = re.compile(r": (what|whether|how|where|which) ")
ABBREVIATION = re.compile(r"\be\.g\.")
EXCLAMATION = re.compile(r"\w!(?=\s|$)")
BRITISH = re.compile(
    r"\b(\w*cent(?:re|red|res)|neighbour\w*|\w*colour\w*|grey\w*|(?:nano|micro|milli|kilo)?metres?|"
    r"catalogue\w*|aluminium|(?:un)?levell\w+|cancell(?:ed|ing)|travell\w+|labell\w+|modell\w+|"
    r"behaviour\w*|licence\w*|favour\w*|honour\w*|analys(?:e|ed|es)\b|ratchett\w+|"
    r"\w+[iy]s(?:e|ed|es|ing|ation)\b(?<!wise)(?<!rise)(?<!noise)(?<!precise)(?<!exercise))",
    re.IGNORECASE,
)
# Words in -ise, -yse that are none of these.
NO_SPELLING = re.compile(
    r"(?i)\b(wise|likewise|counterclockwise|clockwise|otherwise|pointwise|pairwise|stepwise|"
    r"raised?|rais(es|ing)|arises?|rises?|noise|precise|concise|exercise|premises?|promis(e|ed|es)|"
    r"surprise\w*|advis\w+|revis\w+|compris\w+|devis\w+|enterprise|disguise|expertise|bruise|"
    r"cruise|praise|excise|poise|demise|franchise|paradise|treatise|improvise\w*|supervis\w+|"
    r"appraise\w*|phrase\w*|rising|arising|promising|raising|advertis\w+|televis\w+|otherwise|"
    r"basis|axes|wise|hypothesis|analysis|synthesis|crisis)\b"
)
# Quotations, titles of papers, names of files and of other programs' options.
ALLOWED = {
    "docs/claims.md": "names of tests",
}


def prose(text: str) -> str:
    """Return a page without code, targets of links, comments, formulas and its bibliography."""
    text = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
    text = text.partition("\n## Sources\n")[0]
    text = re.sub(r"<!--.*?-->|`[^`]*`|\$[^$]*\$|\]\([^)]*\)|https?://\S+", "", text, flags=re.DOTALL)
    return text


def faults(text: str) -> Iterator[str]:
    """Yield the banned words of a text."""
    plain = " ".join(text.split())
    for expression, instead in BANNED.items():
        for found in re.finditer(rf"(?<![\w-])({expression})(?![\w-])", plain, re.IGNORECASE):
            yield f"“{plain[max(found.start() - 30, 0) : found.end() + 20]}” → {instead}"
    for expression in (COLON_LOGIC, EXCLAMATION):
        for found in expression.finditer(plain):
            yield f"“{plain[max(found.start() - 30, 0) : found.end() + 20]}”"
    for found in BRITISH.finditer(plain):
        if not NO_SPELLING.fullmatch(found[0]):
            yield f"spelling: {found[0]}"
