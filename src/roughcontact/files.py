"""Files that are whole or not there, places where they may go, and JSON."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from roughcontact.errors import InputError


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary name beside a file and move it there at the end.

    Parameters
    ----------
    path : str or path
        The file wanted.

    Yields
    ------
    Path
        Where to write. If the block fails nothing new stays behind, and an old file survives.
    """
    target = Path(path)
    # A name of its own for every call: threads may write the same file, and the last one stays.
    own = f"{os.getpid()}-{os.urandom(4).hex()}"
    temporary = target.with_name(f".{target.stem}.{own}{target.suffix}")
    try:
        yield temporary
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)


def require_suffix(path: str | os.PathLike[str], *suffixes: str) -> None:
    """Raise `InputError` unless a file is named for a format that it can have.

    Parameters
    ----------
    path : str or path
        The file wanted.
    *suffixes : str
        How it may end, such as ``".nc"``.
    """
    if Path(path).suffix.lower() not in suffixes:
        raise InputError(
            f"must end in {' or '.join(suffixes)}, got {str(path)!r}",
            argument="path",
            value=str(path),
        )


def to_json(values: Mapping[str, Any]) -> str:
    """Return JSON text.

    Parameters
    ----------
    values : mapping
        Numbers, words, lists and dictionaries of them.

    Returns
    -------
    str
        Text that every reader of JSON takes: what is not finite, of which JSON knows nothing,
        is ``null``.

    Examples
    --------
    >>> print(to_json({"young": float("inf"), "poisson": 0.5}))
    {
      "young": null,
      "poisson": 0.5
    }
    """
    return json.dumps(_finite(values), indent=2, allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
