"""How a map is shared out to ranks; what ranks do is tested below tests/mpi."""

from itertools import pairwise

import pytest

from roughcontact._tools import ranks
from roughcontact.contact.share import row_bands
from roughcontact.errors import InputError
from roughcontact.solvers import bounded


@pytest.mark.parametrize(
    "shape", [(64, 64), (8192, 8192), (1000, 700), (70, 2000), (30, 9), (5, 5)]
)
def test_bands_are_whole_on_the_coarsest_grid(shape):
    edge = 2 ** bounded.coarser_grids(shape)
    for count in (1, 2, 3, 4, 7):
        if count > shape[0] // max(edge, 2):
            with pytest.raises(InputError, match="over at most"):
                row_bands(shape, count)
            continue
        edges = row_bands(shape, count)
        heights = [last - first for first, last in pairwise(edges)]
        assert (edges[0], edges[-1], len(heights)) == (0, shape[0], count)
        assert all(first % edge == 0 for first in edges[:-1])
        # A row left over goes to the last.
        assert min(heights) >= 2
        assert max(heights) - min(heights) <= 2 * max(edge, 2)


@pytest.mark.parametrize(
    ("environment", "expected"),
    [
        ({}, False),
        ({"PMI_SIZE": "1"}, False),
        ({"PMI_SIZE": "4"}, True),
        ({"OMPI_COMM_WORLD_SIZE": "2"}, True),
        ({"PMI_SIZE": ""}, False),
    ],
)
def test_parallel_run_is_recognized_by_environment(monkeypatch, environment, expected):
    for name in ranks._SIZES:
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert ranks.is_parallel_run() is expected
