"""The volume operator wave by wave, against numerical integration of elasticity over the depth.

Displacement and traction of one wave exp(i k·x) obey six ordinary differential equations in z
(Stroh, Phil. Mag. 3 (1958) 625, doi:10.1080/14786435808565804), here straight from Hooke's law:
no wave, reflection or layer integral of the operator is used. Layer by layer they are integrated
by the matrix exponential; below the last the solution must decay, by Schur's ordered form.
"""

import numpy as np
import pytest
from scipy.linalg import block_diag, expm, schur

from roughcontact.halfspace import layers, plastic_halfspace, tensors
from roughcontact.halfspace.fft import Workspace

MU, NU = 1.7, 0.3
LAME = 2 * MU * NU / (1 - 2 * NU)
SHAPE, PIXEL = (9, 8), (0.3, 0.5)
THICKNESS = np.array([0.04, 0.3, 0.2, 0.8])
ONE = np.eye(3)
# C_ijkl of Hooke's law.
STIFFNESS = LAME * np.einsum("ij,kl->ijkl", ONE, ONE) + MU * (
    np.einsum("ik,jl->ijkl", ONE, ONE) + np.einsum("il,jk->ijkl", ONE, ONE)
)


def reference(wave, strains, pressure):
    """Return u_z at the surface and the mean stress of each layer, amplitudes of one wave.

    ``wave`` is (kx, ky), ``strains`` the plastic strain in each layer, shape (nz, 3, 3).
    """
    k = np.array([*wave, 0.0])
    normal = STIFFNESS[:, 2, :, 2]
    across = 1j * np.einsum("ikl,l->ik", STIFFNESS[:, 2], k)
    # σ = C (∇u - e): traction t = normal u' + across u - τ, and -i kα σ_iα = t'.
    inverse = np.linalg.inv(normal)
    slope = np.hstack([-inverse @ across, inverse])
    back = 1j * np.einsum("j,ijk->ik", k, STIFFNESS[..., 2])
    plane = -np.einsum("j,ijkl,l->ik", k, STIFFNESS, k)
    system = np.vstack([slope, -back @ slope - np.hstack([plane, np.zeros((3, 3))])])

    def parts(strain):
        stress = np.einsum("ijkl,kl->ij", STIFFNESS, strain)
        steep = inverse @ stress[:, 2]
        return stress, steep, np.append(steep, -back @ steep + 1j * stress @ k)

    def along(z, strain):
        """Return the matrix and the vector that carry a state over z."""
        grown = np.zeros((7, 7), complex)
        grown[:6, :6], grown[:6, 6] = system, parts(strain)[2]
        grown = expm(grown * z)
        return grown[:6, :6], grown[:6, 6]

    # Unknown are the states at all faces of layers; rows: surface, layers, decay below.
    _, vectors, _ = schur(system, output="complex", sort="lhp")
    steps = [along(h, e) for h, e in zip(THICKNESS, strains, strict=True)]
    matrix = np.hstack([block_diag(*[-m for m, _ in steps]), np.zeros((6 * len(steps), 6))])
    matrix[:, 6:] += np.eye(6 * len(steps))
    top = np.hstack([np.zeros((3, 3)), ONE, np.zeros((3, 6 * len(steps)))])
    below = np.hstack([np.zeros((3, 6 * len(steps))), vectors[:, 3:].conj().T])
    right = np.concatenate([[0, 0, -pressure], *[v for _, v in steps], np.zeros(3)])
    states = np.linalg.solve(np.vstack([top, matrix, below]), right).reshape(-1, 6)

    node, weight = np.polynomial.legendre.leggauss(10)
    means = []
    for state, h, strain in zip(states, THICKNESS, strains, strict=False):
        stress, steep, _ = parts(strain)
        total = np.zeros((3, 3), complex)
        for z, w in zip(h * (1 + node) / 2, weight / 2, strict=True):
            matrix, vector = along(z, strain)
            here = matrix @ state + vector
            gradient = 1j * np.outer(here[:3], k)
            gradient[:, 2] += slope @ here + steep
            total += w * (np.einsum("ijkl,kl->ij", STIFFNESS, gradient) - stress)
        means.append(total)
    return states[0, 2], np.array(means)


def operator_result(strain, pressure):
    """Return displacement, and stress tensors, shape (nz, ny, nx, 3, 3), by the operator."""
    shape = pressure.shape
    operator = plastic_halfspace.PlasticHalfSpace(
        shape,
        PIXEL,
        THICKNESS,
        shear_modulus=MU,
        poisson=NU,
        boundary="periodic",
        workspace=Workspace(2),
    )

    def fill(layer, out):
        out[...] = strain[layer]
        return slice(0, shape[0])

    displacement = operator.displacement(fill, trace=True)
    deviator, mean = np.empty(strain.shape), np.empty((len(strain), *shape))
    operator.stress(pressure, lambda layer, s: deviator.__setitem__(layer, s))
    operator.mean_stress(pressure, lambda layer, s: mean.__setitem__(layer, s))
    return displacement, tensors.tensor(deviator.swapaxes(0, 1), mean)


# Turns of the wave over the map (y, x): along each axis, oblique to both sides, and one so short
# that it decays within a layer; then waves at Nyquist, which the grid cannot distinguish from their
# mirror images: the operator is the mean of both, strain for strain.
@pytest.mark.parametrize(
    ("shape", "turns"),
    [(SHAPE, turns) for turns in ((0, 1), (1, 0), (1, 2), (-2, 1), (4, 3), (2, 4), (0, 4))]
    + [((8, 9), (4, 1)), ((8, 6), (-1, 3))],
    ids=str,
)
def test_a_wave_against_integration(shape, turns) -> None:
    rng = np.random.default_rng(7)
    parts = rng.normal(size=(2, len(THICKNESS), 3, 3))
    parts += parts.swapaxes(-1, -2)
    parts -= np.trace(parts, axis1=-2, axis2=-1)[..., None, None] / 3 * ONE
    along_x, along_y = (2 * turns[axis] == shape[axis] for axis in (1, 0))
    # A real amplitude of pressure at Nyquist, where a phase is lost.
    amplitude = 1.3 if along_x or along_y else 1.3 - 0.4j
    strains = parts[0] + 1j * parts[1]
    # A layer without strain lets waves through.
    strains[2] = 0
    ky, kx = (2 * np.pi * t / (n * d) for t, n, d in zip(turns, shape, PIXEL, strict=True))
    y, x = (np.arange(n) * d for n, d in zip(shape, PIXEL, strict=True))
    wave = np.exp(1j * (ky * y[:, None] + kx * x))
    strain = np.einsum("cz,yx->zcyx", tensors.components(strains), wave).real
    displacement, stress = operator_result(strain, (amplitude * wave).real)
    mirrored = (-kx, ky) if along_x else (kx, -ky) if along_y else (kx, ky)
    one, other = (reference(k, strains, amplitude) for k in ((kx, ky), mirrored))
    u, means = (one[0] + other[0]) / 2, (one[1] + other[1]) / 2
    # The displacement by strain alone: less 2 (1 - ν²) p/(E q) = (1 - ν) p/(μ q), the elastic one.
    u -= (1 - NU) / (MU * np.hypot(kx, ky)) * amplitude
    np.testing.assert_allclose(displacement, (u * wave).real, rtol=0, atol=1e-10 * abs(u))
    exact = np.einsum("zij,yx->zyxij", means, wave).real
    np.testing.assert_allclose(stress, exact, rtol=0, atol=1e-10 * np.abs(means).max())


def test_no_mean_strain_in_the_plane_of_a_period() -> None:
    # Strain and pressure everywhere the same: Hooke's law with ε_zz alone.
    parts = np.random.default_rng(8).normal(size=(len(THICKNESS), 3, 3))
    parts += parts.swapaxes(-1, -2)
    parts -= np.trace(parts, axis1=-2, axis2=-1)[..., None, None] / 3 * ONE
    strain = np.repeat(tensors.components(parts).T[..., None], SHAPE[0] * SHAPE[1], axis=-1)
    strain = strain.reshape(-1, 5, *SHAPE)
    displacement, stress = operator_result(strain, np.full(SHAPE, 1.3))
    expected = 0.0
    for layer, e in enumerate(parts):
        # Unknown ∂u/∂z make σ_iz = (0, 0, -p).
        slope = np.linalg.solve(
            STIFFNESS[:, 2, :, 2],
            np.einsum("ikl,kl->i", STIFFNESS[:, 2], e) - np.array([0, 0, 1.3]),
        )
        gradient = np.zeros((3, 3))
        gradient[:, 2] = slope
        exact = np.einsum("ijkl,kl->ij", STIFFNESS, gradient - e)
        np.testing.assert_allclose(
            stress[layer], np.broadcast_to(exact, (*SHAPE, 3, 3)), rtol=0, atol=1e-12
        )
        # The growth of the layer lifts the surface.
        elastic = -1.3 / (LAME + 2 * MU)
        expected -= THICKNESS[layer] * (slope[2] - elastic)
    np.testing.assert_allclose(displacement, expected, rtol=1e-12)


def test_the_longest_wave_of_an_isolated_map_is_the_mean_of_all_directions() -> None:
    # The stress of a wave has no harmonics of its direction above the fourth.
    angle = np.linspace(0, 2 * np.pi, 6, endpoint=False)
    limits = [
        reference(1e-6 * np.array([np.cos(a), np.sin(a)]), np.zeros((4, 3, 3)), 1.0)[1]
        for a in angle
    ]
    operator = layers.PeriodicHalfSpace(
        SHAPE, PIXEL, THICKNESS, MU, NU, SHAPE, isolated=True, workspace=Workspace(1)
    )
    operator.displacement(lambda layer, out: None, trace=True)
    deviator, mean = np.empty((4, 5, *SHAPE)), np.empty((4, *SHAPE))
    ones = np.ones(SHAPE)
    operator.stress(ones, lambda layer, s: deviator.__setitem__(layer, s))
    operator.mean_stress(ones, lambda layer, s: mean.__setitem__(layer, s))
    stress = tensors.tensor(deviator.swapaxes(0, 1), mean)
    exact = np.mean(limits, axis=0).real[:, None, None]
    # Of first order in the wave number times the depth, 2e-6.
    np.testing.assert_allclose(stress, np.broadcast_to(exact, stress.shape), rtol=0, atol=1e-5)
    np.testing.assert_allclose(stress[..., 0, 0], -(1 + 2 * NU) / 2, rtol=1e-12)
