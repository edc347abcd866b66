from __future__ import annotations

import math
from pathlib import Path

import openpyxl

from roughcontact.formats.spreadsheets import write_workbook


def test_workbook_keeps_numbers_and_holds_no_formula(tmp_path: Path) -> None:
    rows = [("load [N]", "=1+1, x"), (0.25, 3), (math.nan, math.inf)]
    write_workbook(rows, tmp_path / "table.xlsx")
    cells = list(openpyxl.load_workbook(tmp_path / "table.xlsx").active.rows)
    assert [[cell.value for cell in row] for row in cells] == [
        ["load [N]", "'=1+1, x"],
        [0.25, 3],
        ["nan", "inf"],
    ]
    assert {cell.data_type for row in cells for cell in row} == {"s", "n"}
