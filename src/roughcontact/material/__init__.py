"""Materials: constants, hardening, hardness, catalog."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__, submodules=("catalog", "hardening", "hardness", "material")
)
