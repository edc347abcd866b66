"""Package that imports nothing; its modules are those of SurfaceTopography's ``IO``."""

from pkgutil import extend_path

__path__ = extend_path(__path__, __name__)
