"""The loop on small spheres: laws that must hold for any resolution, and bad input."""

import tracemalloc

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.cautions import CautionTag
from roughcontact.contact.pair import Pair
from roughcontact.elastoplastic import increments, problem as contact_solver, solve
from roughcontact.elastoplastic.archive import load_elastoplastic
from roughcontact.elastoplastic.problem import ElastoplasticProblem, memory_estimate
from roughcontact.elastoplastic.solve import solve_elastoplastic
from roughcontact.errors import (
    ArgumentRef,
    CapacityError,
    ConvergenceError,
    FormatError,
    InputError,
    InsufficientMemoryError,
)
from roughcontact.halfspace import convolution, tensors
from roughcontact.halfspace.fft import Workspace
from roughcontact.material.hardening import Perfect, Swift, Tabulated

YOUNG, POISSON = 210e9, 0.3
RADIUS = 105e-6
PIXEL = 1.0e-6
SWIFT = rc.Material(young=YOUNG, poisson=POISSON, hardening=Swift(1240e6, 30, 0.085))
PERFECT = rc.Material(young=YOUNG, poisson=POISSON, yield_strength=1656e6)
ELASTIC = rc.Material(young=YOUNG, poisson=POISSON)
MORE = dict(depth=18e-6)
FIELDS = ("plastic_strain", "accumulated", "stress", "residual_stress")


def ball(shape=(24, 22), pixel=(PIXEL, PIXEL), factor=1.0):
    y = (np.arange(shape[0]) - (shape[0] - 1) / 2) * pixel[0]
    x = (np.arange(shape[1]) - (shape[1] - 1) / 2) * pixel[1]
    return rc.Surface(-factor * (y[:, None] ** 2 + x**2) / (2 * RADIUS), pixel=pixel)


@pytest.fixture(scope="module")
def loaded():
    return solve_elastoplastic(ball(), material=SWIFT, increments=1, loads=[0.2, 0.4, 0.65], **MORE)


@pytest.fixture(scope="module")
def unloaded(loaded):
    return solve_elastoplastic(ball(), material=SWIFT, increments=1, loads=[0.3, 0.0], start=loaded)


def test_the_state_is_admissible(loaded) -> None:
    assert loaded.converged
    assert loaded.contact.converged
    assert loaded.residual <= loaded.tolerance
    for step in loaded.increments:
        assert step.residual == min(step.residuals)
        assert all(residual > loaded.tolerance for residual in step.residuals[:-1])
    # The stress may pass the yield strength by what the residual leaves: 1e-4 · 2μ ε/Y.
    assert abs(loaded.yield_excess) < 1e-3
    body = loaded.bodies[0]
    strength = SWIFT.hardening.strength(body.accumulated)
    flowed = body.accumulated > 0
    assert 20 < np.count_nonzero(flowed) < flowed.size / 2
    # Under growing load all yielded cells are at yield, but for those that have unloaded.
    np.testing.assert_array_less(body.von_mises, strength * 1.001)
    assert np.median(body.von_mises[flowed] / strength[flowed]) == pytest.approx(1, abs=1e-3)
    assert loaded.regime == "plastic up to the surface"
    assert loaded.warnings == ()
    assert loaded.plastic_depth < 18e-6
    assert body.plastic_volume == loaded.plastic_volume
    assert loaded.increments[-1].plastic_volume == pytest.approx(loaded.plastic_volume)


def test_states_passed_to_on_step_keep_their_values(loaded) -> None:
    kept = []

    def on_step(number, state) -> None:
        arrays = [getattr(body, name) for body in state.bodies for name in FIELDS]
        kept.append((arrays, [array.copy() for array in arrays]))

    loads = [0.2, 0.4, 0.65]
    solve_elastoplastic(ball(), material=SWIFT, increments=1, loads=loads, on_step=on_step, **MORE)
    assert len(kept) == 3
    for arrays, copies in kept:
        for array, copy in zip(arrays, copies, strict=True):
            np.testing.assert_array_equal(array, copy)
            assert not array.flags.writeable
    for array, name in zip(kept[-1][0], FIELDS, strict=True):
        np.testing.assert_array_equal(array, getattr(loaded.bodies[0], name))


def test_gap_certificate_and_load(loaded) -> None:
    contact = loaded.contact
    area = PIXEL**2
    assert contact.pressure.sum() * area == pytest.approx(0.65, rel=1e-10)
    # The gap again, from pressure and residual displacement alone.
    elastic = convolution.free(contact.pressure.shape, (PIXEL, PIXEL), contact.contact_modulus)
    gap = contact.initial_gap + elastic(contact.pressure) + loaded.residual_displacement
    gap -= contact.approach
    np.testing.assert_allclose(contact.gap, gap, atol=1e-15)
    assert gap.min() > -1e-11
    assert np.abs(gap[contact.contact]).max() < 1e-11


@pytest.mark.long
def test_below_first_yield_it_is_the_elastic_solution() -> None:
    # p₀ = 1.5 σ_Y at ν = 0.3 is below 1.6 σ_Y, 1.75 σ_Y above, for Hertz's sphere.
    modulus = YOUNG / (1 - POISSON**2)
    load = [(f * 1656e6 * np.pi) ** 3 * RADIUS**2 / (6 * modulus**2) for f in (1.5, 1.75)]
    fine = ball((40, 40), (1.5e-7, 1.5e-7))
    result = solve_elastoplastic(fine, material=PERFECT, increments=1, loads=[load[0]])
    elastic = rc.solve(fine, material=PERFECT, load=load[0], ceiling=None)
    assert result.plastic_volume == 0
    assert result.regime == "elastic"
    np.testing.assert_allclose(
        result.contact.pressure, elastic.pressure, atol=1e-5 * elastic.max_pressure
    )
    assert result.contact.approach == pytest.approx(elastic.approach, rel=1e-6)
    assert result.yield_excess < 0
    more = solve_elastoplastic(fine, material=PERFECT, increments=1, loads=[load[1]], start=result)
    assert more.plastic_volume > 0
    assert more.regime == "plastic below the surface"
    # First yield is on the axis, 0.48 a below the surface (Johnson 1985, section 4.2).
    body = more.bodies[0]
    layer, row, column = np.unravel_index(body.accumulated.argmax(), body.accumulated.shape)
    a = np.sqrt(more.contact.contact_area / np.pi)
    assert body.depth[layer] / a == pytest.approx(0.48, abs=0.1)
    middle = (body.accumulated.shape[1] - 1) / 2
    assert abs(row - middle) <= 1
    assert abs(column - middle) <= 1


def test_unloading_is_elastic_and_leaves_stress_in_balance(loaded, unloaded) -> None:
    before, after = loaded.bodies[0], unloaded.bodies[0]
    np.testing.assert_array_equal(after.plastic_strain, before.plastic_strain)
    assert unloaded.contact.load == 0
    assert unloaded.contact.max_pressure == 0
    assert unloaded.contact.approach > 0  # the dent that is left
    assert unloaded.regime == loaded.regime
    assert unloaded.contact.gap.min() == pytest.approx(0, abs=1e-15)
    assert [step.iterations for step in unloaded.increments[-2:]] == [1, 1]
    np.testing.assert_array_equal(after.stress, after.residual_stress)
    np.testing.assert_allclose(after.residual_stress, before.residual_stress, atol=1e3)
    # No traction is left where the surface is free, but for the average over half a pixel.
    stress = tensors.tensor(after.residual_stress.swapaxes(0, 1), after.mean_residual_stress)
    assert np.abs(stress[0, ..., 2, 2]).max() < 0.15 * after.residual_von_mises.max()


@pytest.mark.long
def test_periodic_contact_and_its_balance() -> None:
    loaded = solve_elastoplastic(
        ball(), material=PERFECT, increments=1, loads=[0.2, 0.4], boundary="periodic", **MORE
    )
    assert loaded.converged
    assert loaded.bodies[0].margin == 0
    assert loaded.yield_excess < 1e-3
    body = loaded.bodies[0]
    zz = body.stress[:, 0] + body.mean_stress
    # Every plane carries the load, and the residual stress nothing.
    np.testing.assert_allclose(-zz.mean(axis=(1, 2)) * zz[0].size * PIXEL**2, 0.4, rtol=1e-5)
    residual = tensors.tensor(body.residual_stress.swapaxes(0, 1), body.mean_residual_stress)
    np.testing.assert_allclose(
        residual[..., 2].mean(axis=(1, 2)), 0, atol=1e-5 * body.residual_von_mises.max()
    )


def test_residual_state_carries_no_force() -> None:
    result = solve_elastoplastic(
        ball(),
        material=PERFECT,
        increments=1,
        loads=[0.4, 0.0],
        boundary="periodic",
        precision="double",
        layers=[1.5e-6] * 12,
    )
    body = result.bodies[0]
    stress = tensors.tensor(body.stress.swapaxes(0, 1), body.mean_stress)
    assert np.abs(stress[..., 2]).max() > 1e8
    # Normal and shear force on every plane over the load that was there.
    force = stress[..., 2].sum(axis=(1, 2)) * PIXEL**2
    assert np.abs(force).max() < 1e-8 * 0.4


@pytest.mark.slow
@pytest.mark.long
def test_work_is_dissipated_or_locked_in() -> None:
    up = [0.1, 0.2, 0.3, 0.4, 0.5]
    loaded = solve_elastoplastic(
        ball(), material=PERFECT, increments=1, loads=up, precision="double", **MORE
    )
    down = [*up[-2::-1], 0.0]
    result = solve_elastoplastic(
        ball(), material=PERFECT, increments=1, loads=down, start=loaded, precision="double"
    )
    load, approach = np.array([(0, 0), *((s.load, s.approach) for s in result.increments)]).T
    work = np.sum((load[1:] + load[:-1]) / 2 * np.diff(approach))
    body = result.bodies[0]
    volume = body.pixel_area * body.thickness[:, None, None]
    dissipated = np.sum(PERFECT.yield_strength * body.accumulated * volume)
    product = np.einsum("c,zcyx->zyx", tensors.WEIGHTS, body.stress * body.plastic_strain)
    locked = -np.sum(product * volume) / 2
    assert dissipated > 5 * locked > 0
    # The path in straight lines: 16e-3 with three loads, 3.6e-3 with five, 1.0e-3 with twenty.
    assert work == pytest.approx(dissipated + locked, rel=6e-3)


def test_reloading_closes_the_loop(loaded, unloaded) -> None:
    again = solve_elastoplastic(
        ball(), material=SWIFT, increments=1, loads=[0.3, 0.65], start=unloaded
    )
    np.testing.assert_allclose(
        again.contact.pressure, loaded.contact.pressure, atol=1e-4 * loaded.contact.max_pressure
    )
    assert again.max_plastic_strain == pytest.approx(loaded.max_plastic_strain, rel=1e-3)
    assert again.increments[: len(unloaded.increments)] == unloaded.increments


@pytest.mark.slow
def test_two_equal_bodies_match_body_on_mirror_plane() -> None:
    # Two equal bodies share the gap: each does what it does on a rigid one with half the gap.
    both = solve_elastoplastic(
        ball(), material=SWIFT, counter_material=SWIFT, increments=1, loads=[0.3, 0.6], **MORE
    )
    half = solve_elastoplastic(
        ball(factor=0.5), material=SWIFT, increments=1, loads=[0.3, 0.6], **MORE
    )
    np.testing.assert_allclose(
        both.contact.pressure, half.contact.pressure, atol=1e-4 * half.contact.max_pressure
    )
    assert both.contact.approach == pytest.approx(2 * half.contact.approach, rel=1e-5)
    for body in both.bodies:
        np.testing.assert_allclose(
            body.accumulated, half.bodies[0].accumulated, atol=2e-4 * half.max_plastic_strain
        )


@pytest.mark.long
def test_only_the_counter_body_yields() -> None:
    one = solve_elastoplastic(
        ball(), material=SWIFT, counter_material=ELASTIC, increments=1, loads=[0.4, 0.8], **MORE
    )
    other = solve_elastoplastic(
        ball(), material=ELASTIC, counter_material=SWIFT, increments=1, loads=[0.4, 0.8], **MORE
    )
    np.testing.assert_array_equal(one.contact.pressure, other.contact.pressure)
    assert len(one.bodies) == len(other.bodies) == 1


@pytest.mark.long
def test_single_precision_is_enough() -> None:
    single = solve_elastoplastic(ball(), material=SWIFT, increments=1, loads=[0.65], **MORE)
    double = solve_elastoplastic(
        ball(), material=SWIFT, increments=1, loads=[0.65], precision="double", **MORE
    )
    np.testing.assert_allclose(
        single.contact.pressure, double.contact.pressure, atol=1e-4 * double.contact.max_pressure
    )
    assert single.max_plastic_strain == pytest.approx(double.max_plastic_strain, rel=2e-4)


@pytest.mark.slow
def test_volume_grows_with_the_plastic_zone() -> None:
    shallow = solve_elastoplastic(ball(), material=SWIFT, increments=1, loads=[0.65], depth=3e-6)
    deep = solve_elastoplastic(ball(), material=SWIFT, increments=1, loads=[0.65], **MORE)
    assert shallow.bodies[0].thickness.sum() > 6e-6
    assert shallow.warnings == ()
    np.testing.assert_allclose(
        shallow.contact.pressure, deep.contact.pressure, atol=1e-2 * deep.contact.max_pressure
    )
    # A small map: the contact comes near its edge, and the volume extends beyond it.
    small = solve_elastoplastic(ball((16, 14)), material=SWIFT, increments=1, loads=[0.65], **MORE)
    assert small.bodies[0].margin > 0
    assert small.bodies[0].accumulated.shape[1] == 16 + 2 * small.bodies[0].margin
    inside = deep.contact.pressure[4:-4, 4:-4]
    np.testing.assert_allclose(small.contact.pressure, inside, atol=2e-3 * inside.max())


@pytest.mark.long
def test_layers_that_are_too_few_are_reported() -> None:
    result = solve_elastoplastic(
        ball(), material=SWIFT, increments=1, loads=[0.65], layers=[0.5e-6] * 14
    )
    assert [caution.kind for caution in result.cautions] == [CautionTag.PLASTIC_EDGE]
    assert ArgumentRef("depth") in result.cautions[0].parts
    assert result.bodies[0].thickness.size == 14


@pytest.mark.slow
def test_saved_results_load_and_resume(loaded, tmp_path) -> None:
    path = tmp_path / "state.nc"
    loaded.save(path)
    back = load_elastoplastic(path)
    for one, other in zip(loaded.bodies, back.bodies, strict=True):
        assert one.material == other.material
        for name in [
            "thickness",
            "plastic_strain",
            "accumulated",
            "stress",
            "mean_stress",
            "residual_stress",
            "mean_residual_stress",
        ]:
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    np.testing.assert_array_equal(loaded.residual_displacement, back.residual_displacement)
    assert loaded.increments == back.increments
    assert loaded.summary() == back.summary()
    one = solve_elastoplastic(ball(), material=SWIFT, increments=1, loads=[0.7], start=loaded)
    other = solve_elastoplastic(ball(), material=SWIFT, increments=1, loads=[0.7], start=back)
    np.testing.assert_array_equal(one.contact.pressure, other.contact.pressure)
    whole = rc.read_result(path)
    assert isinstance(whole, rc.ElastoplasticResult)
    assert whole.summary() == loaded.summary()
    with pytest.raises(InputError, match=r"must end in one of \.nc"):
        loaded.save(tmp_path / "state.txt")


def test_files_that_are_no_result(loaded, tmp_path) -> None:
    with pytest.raises(FormatError, match="does not exist"):
        load_elastoplastic(tmp_path / "none.nc")
    plain = tmp_path / "contact.nc"
    loaded.contact.save(plain)
    with pytest.raises(FormatError, match=r"written by ElastoplasticResult\.save"):
        load_elastoplastic(plain)


def test_progress_and_cut_increments() -> None:
    steps = []
    with pytest.raises(ConvergenceError, match="did not converge in 2 iterations") as caught:
        solve_elastoplastic(
            ball(),
            material=PERFECT,
            increments=1,
            loads=[0.02, 0.65],
            max_iterations=2,
            progress=steps.append,
            boundary="periodic",
            **MORE,
        )
    result = caught.value.result
    assert not result.converged
    assert result.contact.load == result.increments[-1].load < 0.65
    assert len({at.step.load for at in steps}) > 3  # halved again and again
    assert {(at.number, at.count) for at in steps} == {(1, 2), (2, 2)}
    (caution,) = [c for c in result.cautions if c.kind == CautionTag.NOT_CONVERGED]
    assert "halved 5 times" in result.status
    assert ArgumentRef("max_iterations") in caution.parts


@pytest.mark.slow
def test_an_increment_that_is_too_large_is_cut() -> None:
    # Perfect plasticity needs more iterations for the whole step than for half of it.
    cheap = dict(material=PERFECT, increments=1, loads=[0.6], boundary="periodic", **MORE)
    whole = solve_elastoplastic(ball(), **cheap)
    cut = solve_elastoplastic(ball(), max_iterations=whole.increments[0].iterations - 1, **cheap)
    assert cut.converged
    assert len(cut.increments) > 1
    assert cut.increments[-1].load == 0.6


def test_unknowns_that_join_keep_the_memory() -> None:
    small, large = (increments.Mixer([1.0], Workspace(1)) for _ in range(2))
    rng = np.random.default_rng(5)
    place = np.array([0, 2, 3])
    for step in range(6):
        x, f = rng.normal(size=(2, 5, 3)) * 0.5**step
        narrow = small.mix([x.copy()], [f.copy()])[0]
        if step < 3:
            large.mix([x.copy()], [f.copy()])
            continue
        if step == 3:
            large.grow(0, np.array([4, 7, 8]), np.array([4, 5, 7, 8]))
        wide = large.mix(
            [increments.embed_columns(x, place, 4)], [increments.embed_columns(f, place, 4)]
        )[0]
        np.testing.assert_allclose(wide[:, place], narrow, rtol=1e-9)
        np.testing.assert_array_equal(wide[:, 1], 0)


@pytest.mark.long
def test_load_increments_are_equal() -> None:
    result = solve_elastoplastic(ball(), material=SWIFT, load=0.2, increments=4, **MORE)
    loads = [step.load for step in result.increments]
    np.testing.assert_allclose(loads, [0.05, 0.1, 0.15, 0.2])


@pytest.mark.long
def test_last_increment_has_exact_load() -> None:
    # 0.1 · 3/3 is not 0.1 in floating point.
    assert 0.1 * 3 / 3 != 0.1
    result = solve_elastoplastic(ball((8, 8)), material=SWIFT, load=0.1, increments=3, **MORE)
    assert result.contact.load == result.increments[-1].load == 0.1


def test_a_strength_beyond_single_precision_leaves_the_body_elastic() -> None:
    # Squared it is more than single precision can hold; warnings are errors here.
    hard = rc.Material(young=YOUNG, poisson=POISSON, yield_strength=1e20)
    result = solve_elastoplastic(ball((8, 8)), material=hard, increments=1, loads=[0.1], **MORE)
    assert result.regime == "elastic"
    assert result.yield_excess == -1


@pytest.mark.long
def test_stress_far_above_yield_strength_gives_caution() -> None:
    # Strains of 30000 yield strains: of them the tolerance is more than the yield strength.
    soft = rc.Material(young=YOUNG, poisson=POISSON, yield_strength=1e6)
    result = solve_elastoplastic(
        ball((8, 8)),
        material=soft,
        increments=1,
        loads=[0.1],
        boundary="periodic",
        tolerance=1e-3,
        **MORE,
    )
    assert result.converged
    assert result.yield_excess > 1
    (caution,) = (c for c in result.cautions if c.kind == CautionTag.YIELD_EXCESS)
    assert caution.numbers == {"yield_excess": result.yield_excess}
    assert ArgumentRef("tolerance") in caution.parts


HOLES = ball().heights.copy()
HOLES[3, 4] = np.nan


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (dict(material=ELASTIC), "neither material has a yield strength"),
        (dict(surface=np.zeros((9, 9))), "surface must be a Surface"),
        (dict(surface=ball((6, 9))), "at least 8"),
        (dict(surface=rc.Surface(HOLES, pixel=(PIXEL, PIXEL))), "missing points"),
        (dict(loads=None), "either load, loads or path"),
        (dict(load=1.0), "either load, loads or path"),
        (dict(loads=None, load=-1.0), "load must be positive"),
        (dict(loads=[]), "loads must be finite and not negative"),
        (dict(loads=[0.1, -0.1]), "loads must be finite and not negative"),
        (dict(loads=[np.nan]), "loads must be finite and not negative"),
        (dict(loads=["much"]), "loads needs a force with its unit"),
        (dict(loads=[{}]), "loads must be a list of quantities"),
        (dict(loads=[0.0]), "all zero"),
        (dict(increments=0), "increments must be a whole number from 1 to 10000"),
        (dict(max_iterations=1.5), "max_iterations must be a whole number, got 1.5"),
        (dict(tolerance=0.0), "tolerance must be positive"),
        (dict(tolerance=1e-9), "below the limit of single precision"),
        (dict(precision="half"), "precision must be"),
        (dict(boundary="open"), "boundary must be"),
        (dict(on_failure="ignore"), "on_failure must be"),
        (dict(depth=-1.0), "depth must be positive"),
        (dict(depth=1e-5, layers=[1e-6]), "either depth or layers"),
        (dict(layers=[]), "layers must be"),
        (dict(layers=[1e-6, 0.0]), "layers must be"),
        (dict(layers=[1e-6, np.inf]), "layers must be a row of finite"),
        (dict(layers=["thin"]), "layers needs a length with its unit"),
        (dict(layers=[{}]), "layers must be a row of finite numbers"),
        (dict(layers=[0.5e-6] * 2), "less than the radius .* of the largest contact spot"),
        (dict(depth=0.5e-6), "is less than a pixel"),
        (
            dict(
                material=rc.Material(young=np.inf, poisson=0.3, yield_strength=1e9),
                counter_material=ELASTIC,
            ),
            "rigid material cannot yield",
        ),
        (dict(counter_surface=ball((24, 20))), "same grid"),
    ],
)
def test_bad_input_is_named_before_anything_runs(change, message) -> None:
    arguments = dict(surface=ball(), material=SWIFT, loads=[0.1]) | change
    surface = arguments.pop("surface")
    with pytest.raises(InputError, match=message):
        solve_elastoplastic(surface, **arguments)


def test_start_must_be_the_same_problem(loaded) -> None:
    for change, message in (
        (dict(surface=ball((24, 24))), "another surface"),
        (dict(material=PERFECT), "another material"),
        (dict(counter_material=ELASTIC), "another counter_material"),
        (dict(boundary="periodic"), "another boundary"),
        (dict(depth=1e-5), "contains its layers"),
        (dict(start=3), "start must be"),
    ):
        arguments = dict(surface=ball(), material=SWIFT, loads=[0.7], start=loaded) | change
        surface = arguments.pop("surface")
        with pytest.raises(InputError, match=message):
            solve_elastoplastic(surface, **arguments)


def test_insufficient_memory_raises_error_before_solve(monkeypatch) -> None:
    class Little:
        available = 1000

    monkeypatch.setattr("psutil.virtual_memory", Little)
    monkeypatch.setattr(solve, "solve_without_load", pytest.fail)
    with pytest.raises(InsufficientMemoryError, match="GiB"):
        solve_elastoplastic(ball(), material=SWIFT, increments=1, loads=[0.1])


def test_load_above_capacity_raises_capacity_error() -> None:
    area = 24 * 22 * PIXEL**2
    with pytest.raises(CapacityError, match="more than the map can carry"):
        solve_elastoplastic(ball(), material=PERFECT, load=3.6 * 1656e6 * area)
    # The softer of two bodies decides; a table ends, other laws do not.
    table = rc.Material(YOUNG, POISSON, hardening=Tabulated((0.0, 0.1), (400e6, 800e6)))
    with pytest.raises(CapacityError, match=r"3\.5 times the largest yield strength"):
        solve_elastoplastic(
            ball(), material=PERFECT, counter_material=table, load=3.6 * 800e6 * area
        )
    problem = ElastoplasticProblem(Pair(ball(), SWIFT), 1e-4, 9, "single")
    contact = contact_solver.solve_without_load(problem, Workspace())
    solve.check_capacity(problem, contact, 10 * 1656e6 * area)


def test_a_volume_that_would_not_fit_does_not_grow(monkeypatch) -> None:
    class Free:
        available = 10**9

    monkeypatch.setattr("psutil.virtual_memory", Free)

    def fill(_) -> None:
        Free.available = 0

    result = solve_elastoplastic(
        ball(),
        material=SWIFT,
        increments=1,
        loads=[0.65],
        depth=3e-6,
        tolerance=1e-2,
        progress=fill,
    )
    assert result.bodies[0].thickness.sum() < 4e-6
    assert CautionTag.PLASTIC_EDGE in {caution.kind for caution in result.cautions}


def test_contact_without_certificate_does_not_converge(monkeypatch) -> None:
    monkeypatch.setattr(contact_solver, "_CONTACT_CONVOLUTIONS", 2)
    monkeypatch.setattr(increments, "_MAX_CUTS", 0)
    with pytest.raises(ConvergenceError, match="the contact did not converge"):
        solve_elastoplastic(
            ball(),
            material=SWIFT,
            increments=1,
            loads=[0.65],
            tolerance=0.5,
            max_iterations=3,
            **MORE,
        )


@pytest.mark.long
@pytest.mark.parametrize(
    ("boundary", "precision", "counter_material"),
    [("free", "single", rc.RIGID), ("periodic", "double", SWIFT)],
    ids=["free", "periodic"],
)
def test_memory_estimate_matches_arrays(boundary, precision, counter_material) -> None:
    arguments = dict(
        material=SWIFT,
        counter_material=counter_material,
        boundary=boundary,
        precision=precision,
        increments=1,
        loads=[0.65],
        layers=[1e-6] * 18,
    )
    # Of a smaller map, tables of the interpreter that grow just then would decide.
    surface = ball((72, 66), (11e-7 / 3, 11e-7 / 3))
    solve_elastoplastic(ball(), material=SWIFT, increments=1, loads=[0.1])  # imports
    tracemalloc.start()
    try:
        result = solve_elastoplastic(surface, **arguments)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    accumulated = result.bodies[0].accumulated
    estimate = memory_estimate(
        accumulated.shape[1:], 18, bodies=len(result.bodies), boundary=boundary, precision=precision
    )
    # A quarter of the volume is reckoned with, 0.15 of it yields.
    assert 0.1 < np.mean(accumulated > 0) < 0.25
    assert 1 < estimate / peak < 1.6


def test_hardening_and_yield_strength_agree() -> None:
    assert SWIFT.yield_strength == SWIFT.hardening.initial
    with pytest.raises(InputError, match="but hardening starts at"):
        rc.Material(young=1e9, poisson=0.3, yield_strength=1e6, hardening=Perfect(2e6))
    with pytest.raises(InputError, match="hardening must be"):
        rc.Material(young=1e9, poisson=0.3, hardening="Swift")
