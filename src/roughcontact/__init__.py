"""Contact of measured rough surfaces: pressure, real contact area and gap."""

from roughcontact import face as face
from roughcontact._version import __version__ as __version__


def __getattr__(name):
    # The names are listed in `__init__.pyi`; a module is imported on first use of one of its names.
    # `lazy_loader` is imported late as well: little may load before the CLI handles Ctrl-C.
    import lazy_loader

    offer, listed, names = lazy_loader.attach_stub(__name__, __file__)
    globals().update(__getattr__=offer, __dir__=listed, __all__=["__version__", *names])
    return globals()[name] if name in globals() else offer(name)


def __dir__():
    __getattr__("__all__")
    return globals()["__dir__"]()
