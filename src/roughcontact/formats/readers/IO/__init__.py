"""Nothing is loaded here; the modules are those of SurfaceTopography's ``IO``."""

import os

from roughcontact.formats import readers

__path__ = [os.path.join(folder, "IO") for folder in readers.__path__]
