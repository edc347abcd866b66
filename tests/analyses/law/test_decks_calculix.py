"""Two blocks pressed through an exported table by CalculiX give the table back."""

import math
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.analyses.history.model import indented_surface
from roughcontact.analyses.law.model import LOADING, UNLOADING

pytestmark = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is absent")

SOFT = rc.Material(210e9, 0.3, 1e9)
COPPER = rc.Conductor(conductivity="400 W/m/K")

# Two cubes of 1 mm, face on face: the first four nodes are fixed, the last four pressed down.
BLOCKS = """*NODE, NSET=ALL
1,0,0,0
2,1,0,0
3,1,1,0
4,0,1,0
5,0,0,1
6,1,0,1
7,1,1,1
8,0,1,1
9,0,0,1
10,1,0,1
11,1,1,1
12,0,1,1
13,0,0,2
14,1,0,2
15,1,1,2
16,0,1,2
*ELEMENT, TYPE=C3D8, ELSET=LOWER
1,1,2,3,4,5,6,7,8
*ELEMENT, TYPE=C3D8, ELSET=UPPER
2,9,10,11,12,13,14,15,16
*NSET, NSET=FOOT
1,2,3,4
*NSET, NSET=HEAD
13,14,15,16
*NSET, NSET=TOP
9,10,11,12,13,14,15,16
*MATERIAL, NAME=STEEL
*ELASTIC
210000.,0.
*SOLID SECTION, ELSET=LOWER, MATERIAL=STEEL
*SOLID SECTION, ELSET=UPPER, MATERIAL=STEEL
*SURFACE, NAME=FIRST, TYPE=ELEMENT
LOWER,S2
*SURFACE, NAME=SECOND, TYPE=ELEMENT
UPPER,S1
*INCLUDE, INPUT=law.ccx
*CONTACT PAIR, INTERACTION=ROUGH_{branch}, TYPE=NODE TO SURFACE
SECOND,FIRST
*BOUNDARY
FOOT,1,3
ALL,1,2
"""
STEP = """*STEP, NLGEOM, INC=1000
*STATIC
1.,1.,1e-9
*BOUNDARY
HEAD,3,3,{down:.10e}
*NODE PRINT, NSET=ALL
U
*NODE PRINT, NSET=HEAD, TOTALS=ONLY
RF
*END STEP
"""


SHEAR = """*STEP, NLGEOM, INC=1000
*STATIC
1.,1.,1e-9
*BOUNDARY
TOP,1,1,{along:.10e}
*NODE PRINT, NSET=TOP, TOTALS=ONLY
RF
*END STEP
"""


def law(friction: float | None = None) -> rc.results.InterfaceLaw:
    surface = rc.Surface(*rc.reference_map(128, 3))
    pressures = np.geomspace(20e6, 1e9, 8).tolist()
    contacts = [
        rc.solve(surface, material=SOFT, load=rc.NominalPressure(p), boundary="periodic")
        for p in pressures
    ]
    left = indented_surface(contacts[-1])
    again = [
        rc.solve(left, material=SOFT, ceiling=None, load=rc.NominalPressure(p), boundary="periodic")
        for p in pressures
    ]
    return rc.interface_law(
        contacts, again, conductor=COPPER, counter_conductor=COPPER, friction=friction
    )


def run_calculix(folder: Path, branch: str, overclosures: list[float]) -> list[tuple[float, float]]:
    """Return overclosure [mm] and pressure [MPa] that the blocks take, step by step."""
    # The blocks give way as well, by some part of it: the positions of the faces are compared.
    deck = BLOCKS.format(branch=branch.upper())
    deck += "".join(STEP.format(down=-value) for value in overclosures)
    (folder / "blocks.inp").write_text(deck, encoding="ascii")
    done = subprocess.run(
        ["ccx", "blocks"], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    text = (folder / "blocks.dat").read_text(encoding="ascii")
    forces = re.findall(r"total force.*?\n\n(.*)\n", text)
    moved = re.findall(r"displacements.*?\n\n((?:.*\n){16})", text)
    assert "Job finished" in done.stdout, done.stdout[-500:]
    times = re.findall(r"total force .* time\s+(\S+)", text)
    ends = {int(float(time)): number for number, time in enumerate(times) if float(time) % 1 == 0}
    found = []
    for number in range(1, len(overclosures) + 1):
        rows = [line.split() for line in moved[ends[number]].splitlines()]
        lower, upper = float(rows[4][3]), float(rows[8][3])
        found.append((lower - upper, -float(forces[ends[number]].split()[2])))
    return found


@pytest.mark.long
@pytest.mark.parametrize("branch", [LOADING, UNLOADING])
def test_two_blocks_give_the_table_back(branch: str, tmp_path: Path) -> None:
    found = law()
    found.save(tmp_path / "law.ccx")
    curve = found.curve(branch)
    # Pressures between the solved ones; the blocks are pressed by what they and the joint take.
    asked = np.geomspace(25e6, 0.95e9, 9)
    closed = (curve.first_touch - curve.separation_at(asked)) * 1e3
    given = closed + 2 * asked * 1e-6 / 210e3
    output = run_calculix(tmp_path, branch, given.tolist())
    assert len(output) == asked.size
    for (overclosure, pressure), p, wanted in zip(output, asked * 1e-6, closed, strict=True):
        assert overclosure == pytest.approx(wanted, rel=0.01)
        # The law itself at the overclosure that came out, to the 1 % of the table.
        low, high = 0.5 * p, 2 * p
        for _ in range(60):
            middle = math.sqrt(low * high)
            reached = (curve.first_touch - curve.separation_at(middle * 1e6)) * 1e3
            low, high = (middle, high) if reached < overclosure else (low, middle)
        assert pressure == pytest.approx(low, rel=0.01)


@pytest.mark.long
@pytest.mark.parametrize(("part", "slides"), [(0.1, False), (10.0, True)])
def test_two_blocks_stick_with_the_slope_of_the_deck(
    part: float, slides: bool, tmp_path: Path
) -> None:
    # CalculiX rounds the corner between stick and slip: far on either side of it.
    friction = 0.15
    found = law(friction)
    found.save(tmp_path / "law.ccx")
    pressure, slope = 500e6, found.branch_steps(LOADING)[-1].tangential_stiffness
    curve = found.curve(LOADING)
    closed = (curve.first_touch - float(curve.separation_at(np.array([pressure]))[0])) * 1e3
    along = part * friction * pressure / slope * 1e3
    deck = BLOCKS.format(branch="LOADING") + STEP.format(down=-closed - 2 * pressure / 210e9)
    (tmp_path / "blocks.inp").write_text(deck + SHEAR.format(along=along), encoding="ascii")
    done = subprocess.run(
        ["ccx", "blocks"], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert "Job finished" in done.stdout, done.stdout[-500:]
    totals = re.findall(r"total force.*?\n\n(.*)\n", (tmp_path / "blocks.dat").read_text())
    shear, _, down = (float(word) for word in totals[-1].split())
    assert -down == pytest.approx(pressure * 1e-6, rel=0.02)
    expected = friction * pressure * 1e-6 if slides else slope * along * 1e-9
    assert abs(shear) == pytest.approx(expected, rel=0.02)
