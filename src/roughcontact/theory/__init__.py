"""Closed forms: Hertz, waves, indenters, and the theory of Persson."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submodules=("hertz", "hertz_elliptic", "indenters", "persson", "waves", "yielding_sphere"),
)
