"""Write the measurements that the pages use, ground.sdf, lapped.sdf and others, into the current folder.

python docs/howto/maps.py

It makes the folder ``maps`` there as well, for the figures of the pages.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import roughcontact as rc
from roughcontact.surface import random_surfaces

SIDE = 1e-4


def save(path: Path, heights: np.ndarray, pixel: float) -> None:
    """Write an ISO 25178-71 text file, heights in steps of 0.1 nm.

    Parameters
    ----------
    path : Path
        File to write.
    heights : ndarray, shape (ny, nx)
        Heights [m], NaN where missing.
    pixel : float
        Pixel edge [m].
    """
    ny, nx = heights.shape
    head = {
        "ManufacID": "EXAMPLE",
        "CreateDate": "010120250000",
        "ModDate": "010120250000",
        "NumPoints": nx,
        "NumProfiles": ny,
        "Xscale": pixel,
        "Yscale": pixel,
        "Zscale": 1e-10,
        "Zresolution": -1,
        "Compression": 0,
        "DataType": 6,
        "CheckType": 0,
    }
    steps = np.char.mod("%d", np.nan_to_num(np.rint(heights / 1e-10)))
    steps[np.isnan(heights)] = "BAD"
    lines = ["aISO-1.0", *(f"{key} = {value}" for key, value in head.items()), "*"]
    lines += [" ".join(row) for row in steps]
    path.write_text("\n".join([*lines, "*", ""]), encoding="ascii")


def raceway(points: tuple[int, int] = (256, 160), pixel: float = 2e-6) -> np.ndarray:
    """Return a ground raceway of 20 mm radius: the roller's axis along x, grooves along y.

    Parameters
    ----------
    points : (int, int)
        Grid points ``(ny, nx)``.
    pixel : float
        Pixel edge [m].

    Returns
    -------
    ndarray, shape (ny, nx)
        Heights [m]: an rms roughness of 60 nm, on the form that the ring has.
    """
    ny, nx = points
    side = max(points)
    even = random_surfaces.self_affine(
        (side, side),
        (pixel, pixel),
        rms_height=1.0,
        rolloff_wavelength=40e-6,
        cutoff_wavelength=4 * pixel,
        rng=np.random.default_rng(7),
    )
    # The wheel goes along y: waves shorter than a tenth of a millimetre hardly vary that way.
    waves = np.exp(-0.5 * (np.fft.fftfreq(side, pixel) * 50e-6)[:, None] ** 2)
    ground = np.fft.ifft2(np.fft.fft2(even) * waves).real[:ny, :nx]
    y = (np.arange(ny) - (ny - 1) / 2) * pixel
    return 60e-9 * ground / ground.std() - (y**2 / (2 * 0.02))[:, None]


def main() -> None:
    """Write all maps into the current folder, and make one for the figures of the pages."""
    Path("maps").mkdir(exist_ok=True)
    points = 256
    heights, (pixel, _) = random_surfaces.reference_map(points)
    tilt = np.linspace(0, 1.5e-6, points)
    holes = np.random.default_rng(3).random(heights.shape) < 2e-3
    ground = np.where(holes, np.nan, heights + tilt)
    save(Path("ground.sdf"), ground, pixel)
    points = 200
    pixel = SIDE / points
    lapped = random_surfaces.self_affine(
        (points, points),
        (pixel, pixel),
        rms_height=0.05e-6,
        rolloff_wavelength=SIDE / 8,
        cutoff_wavelength=8 * pixel,
        rng=np.random.default_rng(5),
    )
    save(Path("lapped.sdf"), lapped, pixel)
    for name, rms_height, seed in (("turned", 0.12e-6, 11), ("honed", 0.09e-6, 21)):
        for number in range(3):
            piece = random_surfaces.self_affine(
                (points, points),
                (pixel, pixel),
                rms_height=rms_height,
                rolloff_wavelength=SIDE / 8,
                cutoff_wavelength=8 * pixel,
                rng=np.random.default_rng(seed + number),
            )
            save(Path(f"{name}-{number + 1}.sdf"), piece, pixel)
    ring = raceway()
    ring[np.random.default_rng(8).random(ring.shape) < 1e-3] = np.nan
    save(Path("raceway.sdf"), ring + np.linspace(0, 2e-7, ring.shape[1]), 2e-6)
    np.savetxt("matrix.txt", 1e6 * heights[:64, :128], fmt="%.6f")
    trace()
    plate()


def plate() -> None:
    """Write a lapped plate and two measurements: all of it, coarse, and a part with CSI 50x."""
    points, pixel, rng = 512, 2.5e-7, np.random.default_rng(12)
    heights = random_surfaces.self_affine(
        points, pixel, rms_height=0.3e-6, rolloff_wavelength=4e-5, cutoff_wavelength=2e-6, rng=rng
    )
    surface = rc.Surface(heights, (pixel, pixel))
    save(Path("plate-known.sdf"), heights, pixel)
    coarse = rc.measure.Instrument("optical", resolution=6e-6, noise=1e-9)
    image = coarse.measure(surface, points=(128, 128), periodic=True, rng=rng)
    save(Path("plate.sdf"), image.heights, image.pixel[0])
    fine = rc.measure.Instrument.from_name("CSI 50x", noise=1e-9).measure(surface, rng=rng)
    save(Path("plate-fine.sdf"), fine.heights[100:260, 200:360], pixel)


def trace() -> None:
    """Write a stylus trace across the lay of a ground face, in mm and µm."""
    position = 5e-4 * np.arange(9600)
    waves = np.fft.rfftfreq(position.size, 5e-4)
    size = np.where((waves > 0) & (waves < 200), 1 / np.maximum(waves, 4) ** 1.3, 0)
    phase = np.exp(2j * np.pi * np.random.default_rng(3).random(waves.size))
    heights = np.fft.irfft(size * phase, position.size)
    columns = np.column_stack([position, 0.4 * heights / heights.std() + 2 * position])
    np.savetxt("trace.txt", columns, fmt="%.4f", header="X [mm] Z [um]", comments="")


if __name__ == "__main__":
    main()
