import ast

import numpy as np
import pytest
import scipy.fft

from layers import all_nodes, module_paths, parse_module
from paths import ROOT
from roughcontact.halfspace import fft

PACKAGE = ROOT / "src" / "roughcontact"
DOOR = PACKAGE / "halfspace" / "fft.py"
LIBRARIES = ("ducc0", "pyfftw", "scipy.fft", "scipy.fftpack", "numpy.fft", "scipy.signal")
THREADS = ("threading", "_thread", "concurrent.futures", "multiprocessing.pool")
# Wings whose threads compute nothing, and what they do.
WAITING = {
    "fleet": "threads that wait for the processes of single contacts",
    "desk": "threads that wait for the requests of a page, so that other pages continue",
}


def collect_names(tree):
    """Return the dotted names that a module imports, or reaches through what it imports."""
    names, bound = set(), {}
    for node in all_nodes(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                names.add(alias.name)
                bound[alias.asname or alias.name.split(".")[0]] = (
                    alias.name if alias.asname else alias.name.split(".")[0]
                )
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for alias in node.names:
                names.add(f"{node.module}.{alias.name}")
                bound[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    for node in all_nodes(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            names.add(f"{bound.get(node.value.id, node.value.id)}.{node.attr}")
    return names


def from_one_of(modules, names):
    return {
        name
        for name in names
        if any(name == module or name.startswith(f"{module}.") for module in modules)
    }


@pytest.mark.usefixtures("parsed_sources")
def test_only_fft_module_uses_fft_libraries_and_threads():
    # The terminal checks whether it may receive signals; caches of all threads have a lock.
    # Starting a process holds a lock, too. A fork waits for the end of the first process. An
    # interrupt that was dropped comes again in the first thread. Tasks of a worker share its
    # working folder.
    waiting = (
        "terminal.py",
        "cache.py",
        "convolution.py",
        "processes.py",
        "executors.py",
        "runner.py",
        "jobs.py",
    )
    for path in module_paths().values():
        if path == DOOR:
            continue
        names = collect_names(parse_module(path))
        assert not from_one_of(LIBRARIES, names), path
        if path.relative_to(PACKAGE).parts[0] not in WAITING and path.name not in waiting:
            assert not from_one_of(THREADS, names), path


def test_fft_module_uses_fft_libraries_and_threads():
    # The walk above finds what it looks for, however it is imported.
    names = collect_names(parse_module(DOOR))
    assert from_one_of(LIBRARIES, names) >= {"ducc0", "scipy.fft", "numpy.fft"}
    assert from_one_of(THREADS, names)
    for line in (
        "import numpy as np\nnp.fft.rfft(x)",
        "from scipy import fft",
        "import scipy.fft as f",
        "def f():\n    from scipy.fft import rfft2",
        "from numpy import fft as waves",
    ):
        assert from_one_of(LIBRARIES, collect_names(ast.parse(line))), line


def test_both_libraries_find_the_same_lengths_fast(monkeypatch):
    # Grids, and with them results, do not depend on which of them is installed.
    if fft._ducc0 is None:
        pytest.skip("ducc0 is not installed")
    with_ducc0 = [fft.fast_length(points) for points in range(1, 3000)]
    monkeypatch.setattr(fft, "_ducc0", None)
    assert [fft.fast_length(points) for points in range(1, 3000)] == with_ducc0


# For some numbers of points NumPy's and SciPy's factors of an inverse differ in the last bit.
@pytest.mark.parametrize("shape", [(12, 15), (67, 69), (63, 89), (683, 9), (1, 40)])
def test_real_transforms_match_scipy_exactly(shape):
    values = np.random.default_rng(0).standard_normal(shape)
    np.testing.assert_array_equal(fft.rfft(values, 20, 0), scipy.fft.rfft(values, 20, 0))
    spectrum = scipy.fft.rfft(values, norm="forward")
    np.testing.assert_array_equal(fft.rfft(values, norm="forward"), spectrum)
    np.testing.assert_array_equal(
        fft.irfft(spectrum, 18, norm="forward"), scipy.fft.irfft(spectrum, 18, norm="forward")
    )
    expected = scipy.fft.ifft(spectrum, axis=0)
    np.testing.assert_array_equal(fft.ifft(spectrum.copy(), axis=0), expected)
    spectrum = scipy.fft.rfft2(values)
    np.testing.assert_array_equal(fft.rfft2(values), spectrum)
    expected = scipy.fft.irfft2(spectrum, s=values.shape)
    np.testing.assert_array_equal(fft.irfft2(spectrum, values.shape), expected)


SHAPES = [(2, 2), (3, 5), (8, 8), (7, 13), (12, 31), (29, 6), (2, 33), (41, 2)]


def test_free_period_is_even_and_long_enough(backend):
    for shape in SHAPES:
        period = fft.free_period(shape)
        assert all(p % 2 == 0 and p >= 2 * n for p, n in zip(period, shape, strict=True))


@pytest.mark.parametrize("padded", [(7, 9), (10, 16), (15, 9)], ids=str)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_half_spectrum_and_back(backend, padded, dtype) -> None:
    values = np.random.default_rng(8).normal(size=(7, 9)).astype(dtype)
    values[:2] = values[6:] = 0
    out = np.full((padded[0], padded[1] // 2 + 1), np.nan + 0j, np.result_type(dtype, np.complex64))
    spectrum = fft.half_spectrum(values, slice(2, 6), padded, out)
    # The textbook sum, by matrices.
    y, x = np.arange(7), np.arange(9)
    qy = 2 * np.pi * np.arange(padded[0]) / padded[0]
    qx = 2 * np.pi * np.arange(padded[1] // 2 + 1) / padded[1]
    exact = np.exp(-1j * np.outer(qy, y)) @ values @ np.exp(-1j * np.outer(x, qx))
    rounding = 100 * np.finfo(dtype).eps
    assert spectrum.dtype == out.dtype
    np.testing.assert_allclose(spectrum, exact, atol=rounding)
    back = fft.from_half_spectrum(spectrum, (7, 9), padded)
    assert back.dtype == dtype
    np.testing.assert_allclose(back / (padded[0] * padded[1]), values, atol=rounding)


def test_fast_lengths(backend) -> None:
    for points in (1, 2, 7, 17, 61, 127, 1025):
        length = fft.fast_length(points)
        assert points <= length <= 1.3 * points + 1
        while length % 2 == 0:
            length //= 2
        for factor in (3, 5, 7, 11):
            while length % factor == 0:
                length //= factor
        assert length == 1
