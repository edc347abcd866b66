"""Shared fixtures of the tests."""

import gc
import os
import signal
import sys

# Read when NumPy is loaded. One test runs per core, and threads of each that wait
# for the others' take as long again.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import numpy as np
import pytest

import judge
import layers
from messages import fault

# A machine that is busy is no failure: no test is timed.
hypothesis.settings.register_profile("untimed", deadline=None)
hypothesis.settings.load_profile("untimed")

# Compiled modules are shared by all processes that tests start.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# Scripts for other environments.
collect_ignore_glob = ["data/*"]

# Modules and tests stay until the end: no search for garbage has to walk through them.
gc.disable()


def pytest_collection_finish():
    gc.freeze()
    # Syntax trees and figures are many objects and little garbage.
    gc.set_threshold(50_000, 20, 20)
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def in_a_terminal():
    """Children can be interrupted where the tests run in the background or under `nohup`, too."""
    names = [name for name in ("SIGINT", "SIGHUP") if hasattr(signal, name)]
    ignored = [n for n in names if signal.getsignal(getattr(signal, n)) is signal.SIG_IGN]
    for name in ignored:
        handler = signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL
        signal.signal(getattr(signal, name), handler)
    yield
    for name in ignored:
        signal.signal(getattr(signal, name), signal.SIG_IGN)


@pytest.fixture(autouse=True)
def hide_progress_lines(monkeypatch):
    """The message of a command on a slow machine after ten seconds is no result."""
    from roughcontact.cli import terminal

    monkeypatch.setattr(terminal, "PROGRESS_INTERVAL", 3600.0)


@pytest.fixture(scope="session", autouse=True)
def short_messages():
    """Every message that any test makes the program produce is short; files may hold others."""
    from roughcontact.cautions import Caution, CautionTag

    created = Caution.__init__

    def check_words(self, *args, **more):
        created(self, *args, **more)
        assert not (isinstance(self.kind, CautionTag) and fault(self)), fault(self)

    Caution.__init__ = check_words
    yield
    Caution.__init__ = created


@pytest.fixture(scope="session")
def parsed_sources():
    """The sources are parsed before the rules for them, whose time this is not."""
    for path in layers.module_paths().values():
        layers.all_nodes(layers.parse_module(path))


@pytest.fixture(scope="session")
def independent():
    """The independent judges, for tests that import nothing from there."""
    return judge


@pytest.fixture(scope="session")
def loaded():
    """A hardening ball under load, out of the middle of a map of unequal sides and pixels."""
    import roughcontact as rc
    from roughcontact.material.hardening import Swift

    steel = rc.Material(210e9, 0.3, hardening=Swift(1240e6, 30, 0.085), name="M50")
    y, x = np.mgrid[:28, :32] - np.array([13, 17])[:, None, None]
    heights = -((y * 0.6e-6) ** 2 + (x * 0.5e-6) ** 2) / (2 * 105e-6)
    surface = rc.Surface(heights, (0.6e-6, 0.5e-6), rc.Provenance("ball.nc"))
    return rc.solve_elastoplastic(surface, material=steel, increments=1, loads=[0.1, 0.2, 0.35])


@pytest.fixture(scope="session")
def unmoved(loaded):
    """The same ball where not even the first load was reached."""
    import roughcontact as rc

    soft = rc.Material(210e9, 0.3, 1e6)
    return rc.solve_elastoplastic(
        loaded.contact.surface,
        material=soft,
        increments=1,
        loads=[5e-4],
        max_iterations=1,
        on_failure="return",
    )


@pytest.fixture(scope="session")
def released(loaded):
    """The same ball when the load is gone."""
    import roughcontact as rc

    return rc.solve_elastoplastic(
        loaded.contact.surface,
        material=loaded.contact.material,
        increments=1,
        loads=[0.0],
        start=loaded,
    )


@pytest.fixture(params=["ducc0", "scipy"])
def backend(request, monkeypatch):
    """Run a test with each of the FFT libraries."""
    from roughcontact.halfspace import fft

    if request.param == "ducc0":
        if fft._ducc0 is None:
            pytest.skip("ducc0 is not installed")
    else:
        monkeypatch.setattr(fft, "_ducc0", None)
    return request.param


@pytest.fixture
def small_blocks(monkeypatch):
    """Give a small map many row and column blocks, of a number of bytes."""
    from roughcontact.halfspace import fft

    def small_blocks(size):
        for name in ("ROW_BYTES", "COLUMN_BYTES"):
            monkeypatch.setattr(fft, name, size)

    return small_blocks


@pytest.fixture
def undrawn(monkeypatch):
    """Leave the figures of reports empty, where what a page says of itself is checked alone."""
    from roughcontact.drawing import export

    # Width and height, as a PNG file has them.
    empty = bytes(16) + (640).to_bytes(4, "big") + (480).to_bytes(4, "big")
    monkeypatch.setattr(export, "draw_pngs", lambda drawings, *_: [empty] * len(drawings))


@pytest.fixture
def quick(monkeypatch):
    """Leave the figures of reports undrawn: they take most of the time."""
    from roughcontact.drawing import export

    def undrawn(drawings, *_):
        assert all(draw().axes for draw in drawings)
        return [bytes(24)] * len(drawings)

    monkeypatch.setattr(export, "draw_pngs", undrawn)
