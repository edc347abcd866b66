"""Boundary conditions at the edges of a map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import StrEnum
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from roughcontact.errors import InputError, require_choice

if TYPE_CHECKING:
    from roughcontact.halfspace.coating import Coatings
    from roughcontact.halfspace.convolution import Convolution
    from roughcontact.halfspace.fft import Workspace


class Boundary(StrEnum):
    """Boundary condition of a map: periodic or free along each axis.

    A member is a string and equals its value, so that arguments accept either.

    Raises
    ------
    InputError
        If a text is not the value of a member.

    Examples
    --------
    >>> Boundary("periodic-x").periodic_axes, Boundary.FREE == "free"
    ((1,), True)
    """

    FREE = "free"
    PERIODIC = "periodic"
    PERIODIC_X = "periodic-x"
    PERIODIC_Y = "periodic-y"

    @classmethod
    def _missing_(cls, value: object) -> None:
        require_choice(tuple(map(str, cls)), boundary=value)

    @property
    def periodic_axes(self) -> tuple[int, ...]:
        """Axes along which the map is periodic: 0 y, 1 x."""
        return _MODELS[self].periodic_axes

    @property
    def free_axes(self) -> tuple[int, ...]:
        """Axes along which the map ends at its edges."""
        return tuple(axis for axis in (0, 1) if axis not in self.periodic_axes)

    @property
    def meaning(self) -> str:
        """Short description."""
        return _MODELS[self].meaning

    @property
    def works(self) -> tuple[str, ...]:
        """Keys of the references of the response of the half-space."""
        return _MODELS[self].works

    @property
    def profile_boundary(self) -> Boundary:
        """Boundary of a profile, one row of a body that is uniform along y.

        Raises
        ------
        InputError
            If the boundary is not available for profiles.
        """
        name = _MODELS[self].of_profile
        if not name:
            raise self._not_known("profiles", [b for b in Boundary if _MODELS[b].of_profile])
        return Boundary(name)

    def require_known_below(self, what: str) -> None:
        """Raise `InputError` if ``what``, below the surface, is not available."""
        if not _MODELS[self].known_below:
            raise self._not_known(what, [b for b in Boundary if _MODELS[b].known_below])

    def _not_known(self, what: str, known: Sequence[Boundary]) -> InputError:
        names = " or ".join(repr(str(boundary)) for boundary in known)
        return InputError(
            f"= {str(self)!r} is not available for {what}; solve with {names}",
            argument="boundary",
            value=self,
        )

    def operator(
        self,
        shape: tuple[int, int],
        pixel: tuple[float, float],
        contact_modulus: float,
        *,
        coatings: Coatings | None = None,
        **options: Any,
    ) -> Convolution:
        """Return the operator ``pressure → displacement`` of a map.

        Parameters
        ----------
        shape : (int, int)
            Grid points ``(ny, nx)``.
        pixel : (float, float)
            Pixel edges ``(dy, dx)`` [m].
        contact_modulus : float
            E* [Pa].
        coatings : Coatings, optional
            Coatings of the bodies.
        **options
            ``precision``, ``workspace`` and ``datum`` as for `convolution.strip`; the datum is
            ignored if both axes are free or both are periodic.

        Returns
        -------
        Convolution
            The operator.
        """
        of = partial(_MODELS[self].operator, shape, pixel, contact_modulus, **options)
        operator = of(coatings=coatings)
        if coatings is not None and coatings.is_long_wave_soft:
            operator.surface = of(coatings=None).spectrum
        return operator

    def operators(
        self,
        shape: tuple[int, int],
        pixel: tuple[float, float],
        contact_modulus: float,
        *,
        precision: str = "double",
        workspace: Workspace | None = None,
        **options: Any,
    ) -> Callable[[tuple[int, int], tuple[int, int]], Convolution]:
        """Return a factory of the operators of a map, of coarser grids, and of its parts.

        Parameters
        ----------
        shape, pixel, contact_modulus, workspace, **options
            As for `operator`.
        precision : {"double", "single"}
            Arithmetic on the grid of the map.

        Returns
        -------
        callable
            ``operator(shape, (ky, kx))`` as required by `bounded.solve`.
        """
        from roughcontact.halfspace import gpu
        from roughcontact.halfspace.fft import Workspace

        # The zero of the displacement depends on the whole map, even if only a part is evaluated.
        options |= {"workspace": workspace or Workspace(), "datum": longer_side(shape, pixel)}

        def operator(shape: tuple[int, int], coarsening: tuple[int, int]) -> Convolution:
            coarse = (coarsening[0] * pixel[0], coarsening[1] * pixel[1])
            # On coarse grids the discretization error exceeds the rounding error.
            arithmetic = precision if coarsening == (1, 1) else "single"
            on_host = self.operator(shape, coarse, contact_modulus, precision=arithmetic, **options)
            return gpu.to_device(on_host)

        return operator

    def operator_memory(self, shape: tuple[int, int], precision: str) -> int:
        """Return the memory that `operator` needs, in bytes.

        Parameters
        ----------
        shape : (int, int)
            Grid points ``(ny, nx)``.
        precision : {"double", "single"}
            Arithmetic of the transforms.

        Returns
        -------
        int
            Memory of the row spectra and of one quadrant of the kernel spectrum.
        """
        ny, nx = shape
        real = 8 if precision == "double" else 4
        padded_x = 2 if 1 in self.free_axes else 1
        kernel = self.kernel_memory(shape)
        if precision == "single":
            kernel += kernel // 2
        return 2 * real * ny * (nx * padded_x // 2 + 1) + kernel

    def kernel_memory(self, shape: tuple[int, int]) -> int:
        """Return the bytes of one quadrant of the kernel spectrum in double precision.

        Parameters
        ----------
        shape : (int, int)
            Grid points ``(ny, nx)``.
        """
        own = _MODELS[self].kernel_memory
        if own is not None:
            return own(shape)
        ny, nx = shape
        return 2 * (ny + 1) * (nx + 1) << len(self.free_axes)


def longer_side(shape: tuple[int, int], pixel: tuple[float, float]) -> float:
    """Return the longer side of a map, or the length of a single row [m]."""
    ny, nx = shape
    return nx * pixel[1] if ny == 1 else max(ny * pixel[0], nx * pixel[1])


class _BoundaryModel(NamedTuple):
    """Model of a boundary: everything that depends on the boundary condition.

    A new boundary needs a member of `Boundary` and a model.

    Parameters
    ----------
    periodic_axes : tuple of int
        Axes along which the map is periodic: 0 y, 1 x.
    meaning : str
        Short description.
    works : tuple of str
        Keys of the references of the response in `roughcontact.references`.
    operator : callable
        ``operator(shape, pixel, contact_modulus, datum=, coatings=, precision=, workspace=)``.
    known_below : bool
        Whether stress, plasticity and tangential loading are available.
    of_profile : str
        Value of the boundary of a profile; empty if profiles are not available.
    kernel_memory : callable, optional
        ``kernel_memory(shape)``, bytes of one quadrant of the kernel spectrum in double precision;
        by default of a kernel on the map, twice as long along free axes.
    """

    periodic_axes: tuple[int, ...]
    meaning: str
    works: tuple[str, ...]
    operator: Callable[..., Convolution]
    known_below: bool = False
    of_profile: str = ""
    kernel_memory: Callable[[tuple[int, int]], int] | None = None


# Operators are imported lazily: naming or listing boundaries does not need NumPy.


def _free_operator(*problem: Any, datum: float | None = None, **options: Any) -> Convolution:
    from roughcontact.halfspace import convolution

    return convolution.free(*problem, **options)


def _periodic_operator(*problem: Any, datum: float | None = None, **options: Any) -> Convolution:
    from roughcontact.halfspace import convolution

    return convolution.periodic(*problem, **options)


def _periodic_strip_operator(*problem: Any, **options: Any) -> Convolution:
    from roughcontact.halfspace import convolution

    return convolution.strip(*problem, **options)


def _strip(axis: int) -> _BoundaryModel:
    along, across = ("y", "x") if axis == 0 else ("x", "y")
    return _BoundaryModel(
        (axis,),
        f"the map repeats along {along} and ends along {across}",
        ("Johnson1985", "DLMF"),
        partial(_periodic_strip_operator, axis=axis),
        of_profile="periodic-y" if axis == 0 else "periodic",
    )


_MODELS = {
    Boundary.FREE: _BoundaryModel(
        (),
        "no contact beyond the map edge",
        ("Johnson1985", "Love1929"),
        _free_operator,
        known_below=True,
        of_profile="periodic-y",
    ),
    Boundary.PERIODIC: _BoundaryModel(
        (0, 1),
        "the map is one period of a larger surface",
        ("Johnson1985", "Stanley1997"),
        _periodic_operator,
        known_below=True,
        of_profile="periodic",
    ),
    Boundary.PERIODIC_X: _strip(1),
    Boundary.PERIODIC_Y: _strip(0),
}
