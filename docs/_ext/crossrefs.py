"""Single backticks in docstrings as links, found by the end of a name: `solve`, `hertz.load`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sphinx.util.nodes import make_refnode

if TYPE_CHECKING:
    from docutils import nodes
    from sphinx.addnodes import pending_xref
    from sphinx.application import Sphinx
    from sphinx.environment import BuildEnvironment


def _resolve(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.TextElement
) -> nodes.reference | None:
    if node.get("refdomain") != "py":
        return None
    target = node["reftarget"].removeprefix("roughcontact.")
    objects = env.get_domain("py").objects  # type: ignore[attr-defined]
    place = node.get("py:class") or ""
    tails = [f"{place}.{target}", target] if place else [target]
    for tail in tails:
        found = sorted(
            (name for name in objects if name.endswith(f".{tail}")),
            key=lambda name: (not name.startswith(f"{node.get('py:module')}."), name.count(".")),
        )
        if found:
            name = found[0]
            entry = objects[name]
            return make_refnode(app.builder, node["refdoc"], entry.docname, entry.node_id, content)
    return None


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the resolver."""
    app.connect("missing-reference", _resolve)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
