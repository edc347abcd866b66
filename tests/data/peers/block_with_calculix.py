"""Press a rough elastic block on a rigid flat with CalculiX, ContactMechanics and Tamaas.

python block_with_calculix.py, in an environment with ContactMechanics and Tamaas, and with
CalculiX 2.20 (`ccx`) on the path; writes block.npz in a few minutes of one core. The heights are
even at the edges of the block, whose sides do not move across: mirrored, it is a periodic map.
CalculiX is not based on a half-space: the block has a depth, and its surface has its slopes.
"""

import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from problems import Problem

YOUNG, POISSON = 210e9, 0.3
# Lengths in µm: side and depth of the block, and how far the flat comes down from first touch.
SIDE, DEPTH = 64.0, 64.0
SHIFTS = (1.5, 1.52)
GRIDS = (32, 64)
STORED = Path(__file__).with_name("block.npz")


def heights(points: int) -> np.ndarray:
    """Return heights [µm] at the nodes, (points + 1)², RMS gradient 0.1, highest 0."""
    n = 128
    k = np.hypot(np.fft.fftfreq(n, 1 / n)[:, None], np.fft.fftfreq(n, 1 / n))
    # On twice the side: waves of 16 to 128 µm, roll-off at 64 µm.
    amplitude = np.where((k > 0) & (k <= 8), np.maximum(k, 2) ** -1.8, 0)
    noise = np.random.default_rng(3).standard_normal((n, n))
    z = np.fft.ifft2(np.fft.fft2(noise) * amplitude).real
    for axis in (0, 1):
        z = z + np.roll(np.flip(z, axis), 1, axis)
    slopes = [(np.roll(z, -1, axis) - np.roll(z, 1, axis)) / 2 for axis in (0, 1)]
    z *= 0.1 / np.sqrt(sum((slope**2).mean() for slope in slopes))
    step = 64 // points
    return (z - z.max())[: 64 + 1 : step, : 64 + 1 : step]


def mirror(nodes: np.ndarray) -> np.ndarray:
    """Return values at nodes of the block as those of the periodic map."""
    for axis in (0, 1):
        inner = np.take(nodes, range(nodes.shape[axis] - 2, 0, -1), axis)
        nodes = np.concatenate([nodes, inner], axis)
    return nodes


def write_deck(path: Path, z: np.ndarray) -> None:
    """Write the input of CalculiX: lengths in µm, stresses in GPa, forces in mN."""
    points = len(z) - 1
    pixel = SIDE / points
    layers = pixel * 1.5 ** np.arange(int(np.log(1 + DEPTH / pixel / 2) / np.log(1.5)) + 1)
    levels = np.append(0, np.cumsum(layers[::-1])) * (DEPTH / layers.sum()) - DEPTH
    count = (points + 1) ** 2
    grid = np.arange(count).reshape(points + 1, points + 1) + 1
    number = np.array([grid + count * level for level in range(len(levels))])
    edge = np.arange(points + 1) * pixel
    lines = ["*NODE"]
    for level, depth in enumerate(levels):
        follows = (1 + depth / DEPTH) ** 4
        lines += [
            f"{number[level, j, i]},{edge[i]:.9g},{edge[j]:.9g},{depth + z[j, i] * follows:.12g}"
            for j in range(points + 1)
            for i in range(points + 1)
        ]
    flat = number.max() + 1 + np.arange(8)
    corners = [(-SIDE, -SIDE), (2 * SIDE, -SIDE), (2 * SIDE, 2 * SIDE), (-SIDE, 2 * SIDE)]
    for place, node in enumerate(flat):
        x, y = corners[place % 4]
        lines.append(f"{node},{x},{y},{SIDE * (place // 4)}")
    places = (0, 0), (0, 1), (1, 1), (1, 0)
    lower = [number[:-1, j : points + j, i : points + i] for j, i in places]
    upper = [nodes + count for nodes in lower]
    cells = np.stack([nodes.ravel() for nodes in (*lower, *upper)], 1)
    lines.append("*ELEMENT,TYPE=C3D8,ELSET=BLOCK")
    lines += [f"{n + 1},{','.join(map(str, cell))}" for n, cell in enumerate(cells)]
    lines += ["*ELEMENT,TYPE=C3D8,ELSET=FLAT", f"{len(cells) + 1},{','.join(map(str, flat))}"]
    sets = {
        "BOTTOM": number[0],
        "ENDX": number[:, :, [0, -1]],
        "ENDY": number[:, [0, -1]],
        "TOP": number[-1],
        "RIGID": flat,
    }
    for name, nodes in sets.items():
        lines += [f"*NSET,NSET={name}", *(f"{node}," for node in nodes.ravel())]
    stiffness = 100 * YOUNG / 1e9 / pixel
    lines += [
        "*MATERIAL,NAME=STEEL",
        f"*ELASTIC\n{YOUNG / 1e9},{POISSON}",
        "*SOLID SECTION,ELSET=BLOCK,MATERIAL=STEEL",
        "*SOLID SECTION,ELSET=FLAT,MATERIAL=STEEL",
        f"*SURFACE,NAME=UPPER,TYPE=ELEMENT\n{len(cells) + 1},S1",
        # Faces, not nodes: CalculiX then gives nodes at the edges their part of the area.
        "*SURFACE,NAME=LOWER,TYPE=ELEMENT",
        *(f"{n},S2" for n in range(len(cells) - points**2 + 1, len(cells) + 1)),
        "*SURFACE INTERACTION,NAME=HARD",
        f"*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR\n{stiffness},1e-9,0.01",
        "*CONTACT PAIR,INTERACTION=HARD,TYPE=NODE TO SURFACE\nLOWER,UPPER",
        "*BOUNDARY\nBOTTOM,3,3\nENDX,1,1\nENDY,2,2\nRIGID,1,2",
    ]
    for shift in SHIFTS:
        lines += [
            "*STEP,INC=200\n*STATIC,SOLVER=ITERATIVE SCALING\n1.,1.",
            f"*BOUNDARY\nRIGID,3,3,{-shift}",
            "*NODE PRINT,NSET=RIGID\nRF\n*NODE PRINT,NSET=TOP\nU\n*CONTACT PRINT\nCSTR",
            "*END STEP",
        ]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def read_blocks(path: Path) -> list[tuple[str, np.ndarray]]:
    """Return heading and numbers of each table of the output of CalculiX."""
    blocks: list[tuple[str, list[list[float]]]] = []
    for line in path.read_text(encoding="ascii").splitlines():
        numbers = line.split()[-4:]
        if "and time" in line:
            blocks.append((line, []))
        elif blocks and len(numbers) == 4:
            blocks[-1][1].append(list(map(float, numbers)))
    return [(head, np.array(rows)) for head, rows in blocks]


def solve(points: int) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Return nominal pressure [Pa], pressure [Pa] and gap [m] at the nodes for each shift."""
    z = heights(points)
    with tempfile.TemporaryDirectory() as folder:
        write_deck(Path(folder, "block.inp"), z)
        subprocess.run(["ccx", "block"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        blocks = read_blocks(Path(folder, "block.dat"))
    answers = []
    for shift, part in zip(SHIFTS, np.split(np.arange(len(blocks)), len(SHIFTS)), strict=True):
        forces, moved, stresses = (blocks[number][1] for number in part)
        pressure = np.zeros(z.size)
        pressure[stresses[:, 0].astype(int) - int(moved[0, 0])] = stresses[:, 1] * 1e9
        gap = np.maximum(-shift - z - moved[:, 3].reshape(z.shape), 0) * 1e-6
        nominal = abs(forces[:, 3].sum()) / SIDE**2 * 1e9
        answers.append((nominal, pressure.reshape(z.shape), gap))
    return answers


def main() -> None:
    """Solve on all grids; on the finest with the other programs, under the same loads."""
    import with_contactmechanics
    import with_tamaas

    arrays = {}
    for points in GRIDS:
        for number, (nominal, pressure, gap) in enumerate(solve(points)):
            key = f"{points}/{number}"
            arrays |= {f"calculix/{key}/gap": gap, f"nominal/{key}": np.array(nominal)}
            arrays[f"calculix/{key}/pressure"] = pressure
            print(key, nominal, flush=True)
            if points < max(GRIDS):
                continue
            z, pixel = mirror(heights(points)) * 1e-6, SIDE / points * 1e-6
            load = nominal * (len(z) * pixel) ** 2
            problem = Problem(z, (pixel, pixel), load, None, "periodic")
            for program in (with_contactmechanics, with_tamaas):
                name = program.__name__.removeprefix("with_")
                found = program.solve(problem, 1e-10)
                arrays[f"{name}/{key}/pressure"] = found[: points + 1, : points + 1]
    versions = {"calculix": "2.20", "contactmechanics": "1.8.3", "tamaas": "2.9.0"}
    arrays["about"] = np.array(json.dumps(versions))
    np.savez_compressed(STORED, **arrays)


if __name__ == "__main__":
    main()
