"""What the solvers ask of a displacement operator."""

from __future__ import annotations

from collections.abc import Callable

from roughcontact.halfspace.convolution import Convolution

Family = Callable[[tuple[int, int], tuple[int, int]], Convolution]
"""``family(shape, (ky, kx))``: the operator on a map of that shape whose pixels are as large as
``ky × kx`` pixels of the finest one."""
