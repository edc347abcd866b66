"""Pages of the API by wing, and the house drawn as a figure, both from the package itself."""

from __future__ import annotations

import ast
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import roughcontact as rc

sys.path.append(str(Path(__file__).parents[2] / "tests"))
import house

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_GROUND = "Ground"
# Modules that stand above all wings have no page: there is nothing to call in them.
_BESIDE = ("_version", "__init__", "__main__")


def floors() -> dict[str, list[str]]:
    """Return the rooms of every wing, from the ground up; what stands alone is the ground."""
    found: dict[str, list[str]] = {}
    for room in sorted(house.rooms(), key=house.floor_of):
        wing, _, name = room.partition(".")
        if wing in _BESIDE:
            continue
        if not name:
            found.setdefault(_GROUND, []).append(wing)
        elif not name.rpartition(".")[2].startswith("__"):
            found.setdefault(wing, []).append(name)
    return found


def title(wing: str) -> str:
    """Return what a wing holds, in the words of its own docstring."""
    if wing == _GROUND:
        return "What every wing stands on."
    source = (house.PACKAGE / wing / "__init__.py").read_text(encoding="utf-8")
    return (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0]


def modules() -> str:
    """Return the page of all modules in reStructuredText, a section for every wing."""
    lines = [
        "Modules",
        "=======",
        "",
        "From the ground up: a wing imports only wings above it on this page, see",
        ":doc:`../architecture`.",
        "",
        ".. currentmodule:: roughcontact",
        "",
    ]
    for wing, rooms in floors().items():
        head = wing if wing == _GROUND else f"``{wing}``"
        lines += [head, "-" * len(head), "", title(wing), "", ".. autosummary::", ""]
        lines += [f"   {room}" if wing == _GROUND else f"   {wing}.{room}" for room in rooms]
        lines.append("")
    return "\n".join(lines)


def pages() -> dict[str, str]:
    """Return the page of each module by its file's name.

    They are reached from the page of all modules and by the search, and are left out of the
    navigation: some 350 lines in the margin of each page help nobody, and took half of a build.
    """
    found = {}
    for wing, rooms in floors().items():
        for room in rooms:
            name = room if wing == _GROUND else f"{wing}.{room}"
            head = name.replace("_", r"\_")
            lines = [
                ":orphan:",
                "",
                head,
                "=" * len(head),
                "",
                ":doc:`../modules` › " + wing,
                "",
                f".. automodule:: roughcontact.{name}",
                "   :members:",
                "   :show-inheritance:",
                "",
            ]
            found[f"roughcontact.{name}.rst"] = "\n".join(lines)
    return found


def face() -> str:
    """Return the table of what ``import roughcontact as rc`` offers."""
    objects = {name: getattr(rc, name) for name in rc.__all__} | {
        name: value for name, value in vars(rc.results).items() if isinstance(value, type)
    }
    lines = [".. list-table::", ""]
    packages = []
    # Functions before classes, and these before errors.
    for name, value in sorted(objects.items(), key=lambda item: _place(item[1])):
        if isinstance(value, ModuleType) and hasattr(value, "__path__"):
            packages.append(f"``rc.{name}``")
            continue
        if not (isinstance(value, ModuleType) or (callable(value) and value.__doc__)):
            continue
        module = getattr(value, "__module__", "")
        place = value.__name__ if not module else f"{module}.{name}"
        shown = f"rc.{name}" if name in rc.__all__ else f"rc.results.{name}"
        first = (value.__doc__ or "").partition("\n\n")[0]
        lines += [f"   * - :py:obj:`{shown} <{place}>`", f"     - {' '.join(first.split())}"]
    lines += ["", f"Packages with modules of their own, all below: {', '.join(packages)}."]
    return "\n".join(lines) + "\n"


def _place(value: object) -> int:
    """Return the place of a public object in the table by its kind."""
    if not isinstance(value, type):
        return 0
    return 1 + issubclass(value, Exception)


def between() -> Counter[tuple[str, str]]:
    """Return how many imports lead from one wing to another, but for those of the ground."""
    known = floors()
    name = dict.fromkeys(known[_GROUND], _GROUND) | {wing: wing for wing in known}
    found: Counter[tuple[str, str]] = Counter()
    for room, path in house.rooms().items():
        for other in set(house.imports(path)):
            ends = tuple(name.get(end.partition(".")[0]) for end in (room, other))
            # All wings stand on the ground: arcs to it would hide the others.
            if None in ends or _GROUND in ends or ends[0] == ends[1]:
                continue
            found[ends] += 1  # type: ignore[index]
    return found


def draw(figure: Figure) -> None:
    """Draw the wings on their floors, with an arc for every wing that another one imports."""
    from matplotlib.patches import FancyBboxPatch, PathPatch
    from matplotlib.path import Path as Curve

    known = floors()
    height = {wing: floor for floor, wing in enumerate(known)}
    axes = figure.add_subplot()
    shade = ("#e9eef4", "#f6f3ec")
    for wing, floor in height.items():
        axes.add_patch(
            FancyBboxPatch(
                (0, floor - 0.4),
                10,
                0.8,
                boxstyle="round,pad=0,rounding_size=0.12",
                facecolor=shade[floor % 2],
                edgecolor="#9aa7b5",
                linewidth=0.8,
            )
        )
        axes.text(0.2, floor, wing, va="center", fontsize=11, fontweight="bold", color="#1f3a56")
        words = _wrapped(known[wing], 96)
        axes.text(1.75, floor, words, va="center", fontsize=8, color="#333333", linespacing=1.15)
    links = between()
    most = max(links.values())
    for (above, below), count in links.items():
        start, end = height[above], height[below]
        reach = 10 + 0.55 * abs(start - end) ** 0.8
        curve = Curve(
            [(10, start - 0.12), (reach, start - 0.12), (reach, end + 0.12), (10, end + 0.12)],
            [Curve.MOVETO, Curve.CURVE4, Curve.CURVE4, Curve.CURVE4],
        )
        axes.add_patch(
            PathPatch(
                curve,
                fill=False,
                edgecolor="#b4532a",
                alpha=0.25 + 0.6 * count / most,
                linewidth=0.5 + 3 * count / most,
            )
        )
        axes.plot(10.03, end + 0.12, marker="<", color="#b4532a", markersize=3, alpha=0.7)
    axes.set_xlim(-0.1, 14.6)
    axes.set_ylim(-0.6, len(height) - 0.4)
    axes.set_axis_off()


def _wrapped(words: list[str], width: int) -> str:
    lines = [""]
    for word in words:
        if lines[-1] and len(lines[-1]) + len(word) + 3 > width:
            lines.append("")
        lines[-1] += (" · " if lines[-1] else "") + word
    return "\n".join(lines)
