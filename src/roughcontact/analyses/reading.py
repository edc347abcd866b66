"""Reading of results that `save` wrote."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from roughcontact.analyses.roll.model import RollingResult
    from roughcontact.contact.result import ContactResult
    from roughcontact.elastoplastic.volume_result import ElastoplasticResult


def read_result(
    path: str | os.PathLike[str], *, verify: bool = False
) -> ContactResult | ElastoplasticResult | RollingResult:
    """Read a result from a NetCDF file.

    Parameters
    ----------
    path : str or path
        File that ``save`` of a contact, an elastoplastic contact or repeated passes wrote.
    verify : bool
        Whether to recompute load, gap and certificate from pressures and heights, with one
        application of the operator.

    Returns
    -------
    ContactResult, ElastoplasticResult or RollingResult
        The saved result, with identical bits.

    Raises
    ------
    FormatError
        If the file is missing, damaged, changed or not a result of this program, or its solution
        fails the verification.
    InsufficientMemoryError
        If there is not enough memory to verify it.

    Notes
    -----
    The checksums of every file are verified.
    """
    from roughcontact.analyses.roll import model as rolling
    from roughcontact.contact import archive as contact_archive
    from roughcontact.elastoplastic import archive

    dataset = contact_archive.open_archive(path)
    if "rolling_direction" not in dataset.attrs:
        return archive.load_result(path, dataset, verify=verify)
    passes = rolling.load_rolling(path, dataset)
    if verify:
        archive.verify_result(passes.result).require(Path(path).name)
    return passes
