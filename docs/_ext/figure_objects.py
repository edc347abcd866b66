"""Let the gallery show figures of `roughcontact.plots`, which pyplot does not know of."""

from __future__ import annotations

from typing import Any

from matplotlib._pylab_helpers import Gcf
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst, matplotlib_scraper


def scraper(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any], **kw: Any) -> str:
    """Save the figures that a block left behind, those of pyplot first.

    Parameters
    ----------
    block : tuple
        The block of code.
    block_vars : dict
        Its variables and the names of the images to write.
    gallery_conf : dict
        Of sphinx-gallery.
    **kw
        For the scraper of pyplot's figures.

    Returns
    -------
    str
        The images as reStructuredText.
    """
    shown: list[Figure] = block_vars["example_globals"].setdefault("__shown__", [])
    # Those that pyplot knows are saved, closed and forgotten by its own scraper.
    shown += [manager.canvas.figure for manager in Gcf.get_all_fig_managers()]
    rst = matplotlib_scraper(block, block_vars, gallery_conf, **kw)
    paths = []
    for value in list(block_vars["example_globals"].values()):
        if not isinstance(value, Figure) or any(value is other for other in shown):
            continue
        shown.append(value)
        path = next(block_vars["image_path_iterator"])
        value.savefig(path, dpi=110)
        paths.append(path)
    return rst + figure_rst(paths, gallery_conf["src_dir"])
