"""The order of the wings is the architecture: a wing imports only wings below it."""

from __future__ import annotations

import pytest

from house import delegated, floor_of, imports, rooms, wing_of


@pytest.mark.parametrize("room", sorted(rooms()))
def test_a_wing_imports_only_wings_below(room: str) -> None:
    for other, deferred in imports(rooms()[room]):
        if other == "_version" or delegated(room, other, deferred):
            continue
        assert floor_of(other) <= floor_of(room), f"{room} imports {other} from a wing above"


def test_no_circles_inside_a_wing() -> None:
    graph = {
        room: {
            other
            for other, deferred in imports(path)
            if wing_of(other) == wing_of(room) and not delegated(room, other, deferred)
        }
        for room, path in rooms().items()
    }
    done: set[str] = set()
    while len(done) < len(graph):
        ready = {name for name in graph if name not in done and graph[name] <= done}
        assert ready, f"circle among {sorted(graph.keys() - done)}"
        done |= ready
