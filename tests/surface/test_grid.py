import pytest

from roughcontact.surface import grid


@pytest.mark.parametrize("values", [1, 6])
@pytest.mark.parametrize("shape", [(5, 2**19), (2**12, 2**10), (3, 7), (3, 2**22)])
def test_blocks_are_all_rows_and_no_larger_than_they_need_be(shape, values):
    parts = list(grid.row_blocks(shape, values))
    rows = [row for part in parts for row in range(part.start, part.stop)]
    assert rows == list(range(shape[0]))
    made = [(part.stop - part.start) * shape[1] * values for part in parts]
    single = shape[1] * values
    assert max(made) <= max(grid.VALUES, single)
    # One more row would be too many.
    assert len(parts) == 1 or made[0] + single > grid.VALUES
