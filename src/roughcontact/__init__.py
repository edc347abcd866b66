"""Contact of measured rough surfaces: pressure, real contact area, saturated area and gap."""

import lazy_loader

from roughcontact._version import __version__ as __version__

# The names stand in `__init__.pyi`; a module is imported when the first of its names is used.
__getattr__, __dir__, _offered = lazy_loader.attach_stub(__name__, __file__)
__all__ = ["__version__", *_offered]
