"""Texts for users are plain English in US spelling, and short."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import roughcontact as rc
from paths import ROOT
from roughcontact.analyses.tasks import COMMANDS

SOURCE = Path(rc.__file__).parent
HOWTO = sorted((ROOT / "docs" / "howto").glob("*.md"))
PAGES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "docs" / "evidence").glob("*.md")),
    *HOWTO,
]
REPORT = sorted([*(SOURCE / "report").glob("*.py"), *(SOURCE / "report").glob("templates/*")])
GALLERY = sorted((ROOT / "docs" / "gallery").glob("*.py"))
BOUNDARY = SOURCE / "halfspace" / "boundary.py"
# Two of the desk hold JavaScript.
DESK = [path for path in (SOURCE / "desk").glob("*.py") if path.stem not in ("maps", "widgets")]
MESSAGES = sorted([*SOURCE.rglob("*plausibility.py"), *SOURCE.rglob("*messages.py")])

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
    r"not bounded": "no interval",
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
}
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
    r"basis|max_von_mises|max_residual_von_mises|axes|wise|hypothesis|analys[ie]s|synthesis|crisis|Mises)\b"
)


def prose(text: str) -> str:
    """Return a page without code, link targets, formulas, sources and generated blocks."""
    text = text.partition("\n## Sources\n")[0]
    for rest in (
        r"^```.*?^```$",
        r"<!-- ([a-z ]+) -->.*?<!-- (end.*?|\1 end) -->",
        r"<!--.*?-->|`[^`]*`|\$[^$]*\$|\]\([^)]*\)|https?://\S+",
    ):
        text = re.sub(rest, "", text, flags=re.DOTALL | re.MULTILINE)
    return text


def faults(text: str) -> Iterator[str]:
    """Yield what is not plain English in a text, each with a few words around it."""
    plain = " ".join(text.split())
    for expression, instead in BANNED.items():
        for found in re.finditer(rf"(?<![\w-])({expression})(?![\w-])", plain, re.IGNORECASE):
            yield f"{plain[max(found.start() - 30, 0) : found.end() + 20]!r}: write {instead}"
    for expression in (COLON_LOGIC, EXCLAMATION):
        for found in expression.finditer(plain):
            yield repr(plain[max(found.start() - 30, 0) : found.end() + 20])
    for found in BRITISH.finditer(plain):
        if not NO_SPELLING.fullmatch(found[0]):
            yield f"British spelling: {found[0]}"


def docstrings() -> Iterator[tuple[str, str]]:
    """Yield the public names with their docstrings, members of classes included."""
    for name, value in {
        **{name: getattr(rc, name) for name in rc.__all__},
        **vars(rc.results),
    }.items():
        if not callable(value) or not getattr(value, "__module__", "").startswith("roughcontact"):
            continue
        yield name, value.__doc__ or ""
        for member in dir(value) if isinstance(value, type) else ():
            found = inspect.getattr_static(value, member)
            found = getattr(found, "__func__", found)
            own = inspect.isfunction(found) or isinstance(found, property)
            if own and not member.startswith("_"):
                yield f"{name}.{member}", found.__doc__ or ""


def texts(path: Path) -> str:
    """Return the texts of a module without its docstrings, or the text of a template."""
    content = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return re.sub(
            r"<(style|script).*?</\1>|\{[%#{].*?[%#}]\}|<[^>]*>", " ", content, flags=re.DOTALL
        )
    tree = ast.parse(content)
    spoken = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    return "\n".join(
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in spoken
    )


def remarks(path: Path) -> str:
    """Return the prose of a page of the gallery: its docstring and its comments."""
    content = path.read_text(encoding="utf-8")
    lines = [line.removeprefix("# ") for line in content.splitlines() if line.startswith("# ")]
    text = "\n".join([ast.get_docstring(ast.parse(content)) or "", *lines])
    return re.sub(r"``[^`]*``|`[^`]*`", "", text)


def test_patterns_are_found_and_plain_words_are_not() -> None:
    assert list(faults("It hangs on the pixel: what counts is the centre. Done!")) != []
    assert len(list(faults("It hangs on the pixel: what counts is the centre. Done!"))) == 4
    assert list(faults("Otherwise the noise of the analysis raises the area (von Mises).")) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_pages_are_plain_english(page: Path) -> None:
    text = prose(page.read_text(encoding="utf-8"))
    assert [*faults(text), *ABBREVIATION.findall(text)] == []


def test_the_readme_is_short() -> None:
    assert (ROOT / "README.md").read_text(encoding="utf-8").count("\n") <= 110


@pytest.mark.parametrize("page", HOWTO, ids=lambda path: path.stem)
def test_lines_of_how_to_pages_are_short(page: Path) -> None:
    text = re.sub(r"^```.*?^```$", "", page.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
    assert [line for line in text.splitlines() if len(line) > 120 and line[0] != "|"] == []


@pytest.mark.parametrize("command", COMMANDS)
def test_help_is_plain_english_and_short(command: str) -> None:
    shown = COMMANDS[command]
    summary, _, rest = shown.help.partition("\n")
    assert len(summary.split()) <= 12
    assert list(faults(f"{summary} {rest.partition('Example:')[0]}")) == []
    for option in shown.options:
        label = "" if option.label.lower() == option.name.replace("-", " ") else option.label
        assert list(faults(f"{option.help} {label}")) == [], option.name
        # Kinds of boundary and formats of files are listed with their meaning.
        if option.name not in ("boundary", "output"):
            assert len(re.sub(r'"[^"]*"', "X", option.help).split()) <= 17, option.name


def test_public_docstrings_are_plain_english() -> None:
    wrong = {}
    for name, text in docstrings():
        found = list(faults(re.sub(r"``[^`]*``|`[^`]*`|>>>.*", "", text)))
        if found:
            wrong[name] = found
    assert wrong == {}


@pytest.mark.parametrize(
    "path", [*REPORT, *MESSAGES], ids=lambda path: f"{path.parent.name}-{path.stem}"
)
def test_reports_and_messages_are_plain_english(path: Path) -> None:
    assert list(faults(texts(path))) == []


@pytest.mark.parametrize("path", GALLERY, ids=lambda path: path.stem)
def test_the_gallery_is_plain_english(path: Path) -> None:
    assert list(faults(remarks(path))) == []


@pytest.mark.parametrize("path", [BOUNDARY, *sorted(DESK)], ids=lambda path: path.stem)
def test_the_desk_and_boundaries_are_plain_english(path: Path) -> None:
    # A text of one word is a name.
    sentences = (line for line in texts(path).splitlines() if " " in line.strip())
    assert list(faults("\n".join(sentences))) == []
