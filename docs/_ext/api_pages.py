"""Pages of the API by layer, and the figure of the layers, from the package itself."""

from __future__ import annotations

import ast
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import roughcontact as rc

sys.path.append(str(Path(__file__).parents[2] / "tests"))
import layers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BASE = "Base modules"
# These modules have no page: they define no function.
_UNLISTED = ("_version", "__init__", "__main__")


def modules_by_layer() -> dict[str, list[str]]:
    """Return the modules of each layer, from the lowest up; those outside folders come first."""
    found: dict[str, list[str]] = {}
    for module in sorted(layers.module_paths(), key=layers.level_of):
        layer, _, name = module.partition(".")
        if layer in _UNLISTED:
            continue
        if not name:
            found.setdefault(_BASE, []).append(layer)
        elif not name.rpartition(".")[2].startswith("__"):
            found.setdefault(layer, []).append(name)
    return found


def layer_title(layer: str) -> str:
    """Return the first line of the docstring of a layer."""
    if layer == _BASE:
        return "Modules that every layer may import."
    source = (layers.PACKAGE / layer / "__init__.py").read_text(encoding="utf-8")
    return (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0]


def modules_page() -> str:
    """Return the page of all modules in reStructuredText, with a section for each layer."""
    lines = [
        "Modules",
        "=======",
        "",
        "From the lowest layer up: a layer imports only layers above it on this page, see",
        ":doc:`../architecture`.",
        "",
        ".. currentmodule:: roughcontact",
        "",
    ]
    for layer, modules in modules_by_layer().items():
        head = layer if layer == _BASE else f"``{layer}``"
        lines += [head, "-" * len(head), "", layer_title(layer), "", ".. autosummary::", ""]
        lines += [
            f"   {module}" if layer == _BASE else f"   {layer}.{module}" for module in modules
        ]
        lines.append("")
    return "\n".join(lines)


def module_pages() -> dict[str, str]:
    """Return the page of each module by file name.

    They are linked from the page of all modules and found by the search, but are not in the
    navigation: its 350 lines on each page took half of the build.
    """
    found = {}
    for layer, modules in modules_by_layer().items():
        for module in modules:
            name = module if layer == _BASE else f"{layer}.{module}"
            head = name.replace("_", r"\_")
            lines = [
                ":orphan:",
                "",
                head,
                "=" * len(head),
                "",
                ":doc:`../modules` › " + layer,
                "",
                f".. automodule:: roughcontact.{name}",
                "   :members:",
                "   :show-inheritance:",
                "",
            ]
            found[f"roughcontact.{name}.rst"] = "\n".join(lines)
    return found


def public_table() -> str:
    """Return the table of the public names of ``import roughcontact as rc``."""
    objects = {name: getattr(rc, name) for name in rc.__all__} | {
        name: value for name, value in vars(rc.results).items() if isinstance(value, type)
    }
    lines = [".. list-table::", ""]
    packages = []
    # Functions come before classes, and classes before errors.
    for name, value in sorted(objects.items(), key=lambda item: _sort_key(item[1])):
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


def _sort_key(value: object) -> int:
    """Return the sort key of a public object by its kind."""
    if not isinstance(value, type):
        return 0
    return 1 + issubclass(value, Exception)


def imports_between_layers() -> Counter[tuple[str, str]]:
    """Return the number of imports from one layer to another, without the base modules."""
    known = modules_by_layer()
    name = dict.fromkeys(known[_BASE], _BASE) | {layer: layer for layer in known}
    found: Counter[tuple[str, str]] = Counter()
    for module, path in layers.module_paths().items():
        for other in set(layers.imported_modules(path)):
            ends = tuple(name.get(end.partition(".")[0]) for end in (module, other))
            # All layers import base modules: arcs to them would hide the others.
            if None in ends or _BASE in ends or ends[0] == ends[1]:
                continue
            found[ends] += 1  # type: ignore[index]
    return found


def draw_layers(figure: Figure) -> None:
    """Draw the layers from the lowest up, with an arc for each layer that another one imports."""
    from matplotlib.patches import FancyBboxPatch, PathPatch
    from matplotlib.path import Path as Curve

    known = modules_by_layer()
    height = {layer: level for level, layer in enumerate(known)}
    axes = figure.add_subplot()
    shade = ("#e9eef4", "#f6f3ec")
    for layer, level in height.items():
        axes.add_patch(
            FancyBboxPatch(
                (0, level - 0.4),
                10,
                0.8,
                boxstyle="round,pad=0,rounding_size=0.12",
                facecolor=shade[level % 2],
                edgecolor="#9aa7b5",
                linewidth=0.8,
            )
        )
        axes.text(0.2, level, layer, va="center", fontsize=11, fontweight="bold", color="#1f3a56")
        words = _wrap_words(known[layer], 96)
        axes.text(1.75, level, words, va="center", fontsize=8, color="#333333", linespacing=1.15)
    links = imports_between_layers()
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


def _wrap_words(words: list[str], width: int) -> str:
    lines = [""]
    for word in words:
        if lines[-1] and len(lines[-1]) + len(word) + 3 > width:
            lines.append("")
        lines[-1] += (" · " if lines[-1] else "") + word
    return "\n".join(lines)
