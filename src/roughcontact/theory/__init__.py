"""Closed forms: Hertz, waves, indenters, and the theories of rough contact."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submodules=(
        "constriction",
        "greenwood_williamson",
        "height_distribution",
        "hertz",
        "indenters",
        "persson",
        "rarefied_gas",
        "waves",
    ),
)
