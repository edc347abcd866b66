"""Contact of measured rough surfaces: pressure, real contact area, saturated area and gap."""

from roughcontact import wiring as wiring
from roughcontact._version import __version__ as __version__


def __getattr__(name):
    # The names stand in `__init__.pyi`; a module is imported when the first of its names is used.
    # So is what does that: until the command line has seen to Ctrl-C, little may be loaded.
    import lazy_loader

    from roughcontact.renamed import OLD, found

    def known(name):
        return found(name) if name in OLD else offered(name)

    offered, listed, names = lazy_loader.attach_stub(__name__, __file__)
    globals().update(__getattr__=known, __dir__=listed, __all__=["__version__", *names])
    return globals()[name] if name in globals() else known(name)


def __dir__():
    __getattr__("__all__")
    return globals()["__dir__"]()
