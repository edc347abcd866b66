"""The operator on a device, a GPU or PyTorch's processor; errors need no PyTorch."""

import shlex
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.cli import app
from roughcontact.errors import InputError, InsufficientMemoryError
from roughcontact.halfspace import fft, gpu
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.coating import Coatings
from roughcontact.halfspace.fft import Workspace
from roughcontact.material.material import RIGID, Layer, Material

PIXEL, MODULUS = (0.4, 1.0), 3.0
STEEL = Material(young=210e9, poisson=0.3, yield_strength=1e9)
COATED = Material(
    young=210e9, poisson=0.3, yield_strength=1e9, coating=(Layer(300e9, 0.2, thickness=1e-6),)
)
COMMAND = "solve --body 'sphere 1 mm' --points 24 --size '60 um' --material 100Cr6 --load '1 N'"


@pytest.fixture(params=["cpu", "cuda"])
def torch(request, monkeypatch):
    """PyTorch on a GPU, and on a processor in its place; one thread for small maps."""
    result = pytest.importorskip("torch")
    if request.param == "cuda" and not result.cuda.is_available():
        pytest.skip("PyTorch finds no CUDA device")
    result.set_num_threads(1)
    monkeypatch.setattr(gpu, "_find_device", lambda name: result.device(request.param))
    return result


def operators(boundary, shape, precision="double", coatings=None):
    def make():
        family = boundary.operators(
            shape, PIXEL, MODULUS, coatings=coatings, precision=precision, workspace=Workspace(2)
        )
        return family(shape, (1, 1))

    host = make()
    with gpu.use_device("cuda"):
        device = make()
    assert isinstance(device, gpu.DeviceConvolution)
    assert not isinstance(host, gpu.DeviceConvolution)
    return host, device


def assert_same(host, device, pressure):
    index = np.flatnonzero(pressure)
    values = pressure.ravel()[index]
    assert device.real is host.real
    tolerance = {np.float64: 1e-13, np.float32: 1e-5}[host.real]
    for result in (host(pressure), host.gather(host.support(index), values)):
        found = device(pressure)
        if result.ndim == 1:
            found = device.gather(device.support(index), values)
        assert found.dtype == result.dtype
        np.testing.assert_allclose(
            found, result, rtol=0, atol=tolerance * np.abs(result).max(initial=0)
        )


@pytest.mark.parametrize("boundary", Boundary)
@pytest.mark.parametrize("shape", [(7, 13), (12, 31), (40, 6), (1, 33)])
def test_device_operator_matches_host(torch, monkeypatch, boundary, shape):
    # Several blocks of rows and of columns.
    monkeypatch.setattr(fft, "ROW_BYTES", 1000)
    monkeypatch.setattr(gpu, "_BLOCK_BYTES", 4000)
    rng = np.random.default_rng(1)
    pressure = rng.random(shape) * (rng.random(shape) < 0.3)
    pressure[shape[0] // 2 :] = 0
    pressure[0, 2] = 1
    none = np.zeros(shape)
    for precision in ("double", "single"):
        host, device = operators(boundary, shape, precision)
        assert_same(host, device, pressure)
        for derive in ("to_single_precision", "approximate_inverse"):
            assert_same(getattr(host, derive)(), getattr(device, derive)(), pressure)
            assert_same(getattr(host, derive)(), getattr(device, derive)(), none)
        assert_same(host.with_foundation(0.7), device.with_foundation(0.7), pressure)
        assert device.self_displacement == host.self_displacement
        assert device.periodic_axes == host.periodic_axes


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_device_operator_matches_host_for_soft_coating(torch, boundary):
    soft = Layer(1e6, 0.4, thickness=2.0)
    coatings = Coatings.from_bodies(
        Material(1e3, 0.3, coating=(Layer(1e6, 0.3, thickness=0.1), soft)), RIGID
    )
    host, device = operators(Boundary(boundary), (12, 9), coatings=coatings)
    assert device.is_long_wave_soft == host.is_long_wave_soft
    assert_same(host, device, np.random.default_rng(2).random((12, 9)))


@pytest.mark.parametrize("boundary", Boundary)
@pytest.mark.parametrize(
    "options",
    [{}, {"ceiling": None}, {"precision": "single"}, {"material": COATED, "ceiling": "base"}],
)
def test_device_solve_keeps_certificate_and_convolutions(torch, boundary, options):
    surface = rc.Surface(*rc.reference_map(64))
    case = {"material": STEEL, "load": 1.0, "boundary": boundary, **options}
    host, device = (rc.solve(surface, **case, device=name) for name in ("cpu", "cuda"))
    assert device.converged
    assert device.certificate <= device.tolerance == host.tolerance
    assert device.convolutions == host.convolutions
    tolerance = 10 * host.tolerance * np.linalg.norm(host.pressure)
    assert np.linalg.norm(device.pressure - host.pressure) < tolerance
    assert (device.calibrated is None) == (host.calibrated is None)


def count_device_operators(monkeypatch):
    made = []
    create = gpu.DeviceConvolution.__init__
    monkeypatch.setattr(
        gpu.DeviceConvolution, "__init__", lambda *a, **o: made.append(a) or create(*a, **o)
    )
    return made


def test_device_serves_curve_history_search_and_wear(torch, monkeypatch):
    made = count_device_operators(monkeypatch)
    surface = rc.Surface(*rc.reference_map(32))
    case = {"material": STEEL, "device": "cuda"}
    for compute in (
        lambda: rc.sweep(surface, loads=[0.5, 1.0], **case),
        lambda: rc.history(surface, [1.0, 0.0], **case),
        lambda: rc.find_load(surface, contact_fraction=0.1, **case),
        lambda: rc.wear(surface, load=1.0, wear_coefficient=1e-15, distance=1e-4, steps=1, **case),
        lambda: rc.compare([surface] * 2, pressure="100 MPa", steps=1, **case),
    ):
        compute()
        assert made
        made.clear()
    rc.solve(surface, material=STEEL, load=1.0)
    assert not made


def test_small_device_memory_raises(torch, monkeypatch):
    def fail(*_):
        raise torch.OutOfMemoryError("CUDA out of memory")

    monkeypatch.setattr(gpu.DeviceConvolution, "_upload", fail)
    surface = rc.Surface(*rc.reference_map(32))
    with pytest.raises(InsufficientMemoryError, match=r'precision="single".*device="cpu"'):
        rc.solve(surface, material=STEEL, load=1.0, device="cuda")


def test_missing_torch_raises(monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    surface = rc.Surface(*rc.reference_map(32))
    with pytest.raises(InputError, match=r"device = 'cuda' needs PyTorch.*roughcontact\[gpu\]"):
        rc.solve(surface, material=STEEL, load=1.0, device="cuda")


def test_missing_cuda_raises(monkeypatch):
    absent = SimpleNamespace(cuda=SimpleNamespace(is_available=lambda: False), __version__="0")
    monkeypatch.setitem(sys.modules, "torch", absent)
    with (
        pytest.raises(InputError, match=r"finds no CUDA device.*nvidia-smi"),
        gpu.use_device("cuda"),
    ):
        pass
    with pytest.raises(InputError, match="'cpu' or 'cuda', got 'tpu'"), gpu.use_device("tpu"):
        pass


def test_threads_and_nested_calls_keep_the_device(monkeypatch):
    monkeypatch.setattr(gpu, "_find_device", lambda name: name)
    seen = []
    with gpu.use_device("cuda"), gpu.use_device(None):
        Workspace(4).each(lambda _: seen.append(gpu._device.get()), range(50))
        with gpu.use_device("cpu"):
            assert gpu._device.get() is None
    assert set(seen) == {"cuda"}
    assert gpu._device.get() is None


def test_elastoplastic_model_refuses_device(capsys):
    assert app.main(shlex.split(f"{COMMAND} --device cuda --model elastoplastic")) == app.BAD_INPUT
    assert "--device needs --model ceiling" in capsys.readouterr().err


def test_command_solves_on_device(torch, monkeypatch, capsys):
    made = count_device_operators(monkeypatch)
    assert app.main(shlex.split(f"{COMMAND} --device cuda --json")) == 0
    assert made
    assert '"converged": true' in capsys.readouterr().out
