"""Results that `save` wrote, read again."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from roughcontact.contact import archive as contact_archive

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult
    from roughcontact.elastoplastic.result import ElastoplasticResult
    from roughcontact.elastoplastic.rolling import RollingResult


def read_result(
    path: str | os.PathLike[str], *, verify: bool = False
) -> ContactResult | ElastoplasticResult | RollingResult:
    """Read the result that a NetCDF file holds.

    Parameters
    ----------
    path : str or path
        A file that ``save`` of a contact, an elastoplastic contact or repeated passes wrote.
    verify : bool
        Whether to compute load, gap and certificate of the contact again from its pressures and
        heights, with one application of the operator.

    Returns
    -------
    ContactResult, ElastoplasticResult or RollingResult
        The same result; every number keeps its bits.

    Raises
    ------
    FormatError
        If the file is missing, damaged, changed or not a result of this program, or does not hold
        the solution that it claims to be.
    InsufficientMemoryError
        If there is not enough memory to verify it.

    Notes
    -----
    Every file is compared with its checksums.
    """
    from roughcontact.elastoplastic import archive, rolling

    dataset = contact_archive.opened(path)
    if "rolling_direction" not in dataset.attrs:
        return archive.load_result(path, dataset, verify=verify)
    passes = rolling.load_rolling(path, dataset)
    if verify:
        archive.verified(passes.result).require(os.path.basename(path))
    return passes
