"""Materials: constants, hardening, hardness, catalogue."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__, submodules=("catalog", "hardening", "hardness", "material")
)
