"""Metadata of measurements, without the validation of pydantic."""

from __future__ import annotations

import importlib.util
import os
from datetime import datetime
from types import NoneType
from typing import Any

from roughcontact.formats import readers

# Metadata of an instrument. Serial numbers are not used: the library drops placeholders of them.
_NAMES = ("name", "vendor", "serial", "scanner_serial", "software")


class InfoModel:
    """Metadata of a file in SurfaceTopography, as plain types."""

    def __init__(self, **fields: Any) -> None:
        self._fields = _check_fields(fields)

    def model_dump(self, *, exclude_none: bool = True) -> dict[str, Any]:
        """Return the metadata by name."""
        return dict(self._fields)


def _check_fields(fields: dict[str, Any]) -> dict[str, Any]:
    try:
        plain = {
            **fields,
            **_typed(fields, acquisition_time=datetime, channel_name=str, datafile=dict),
        }
        plain["instrument"] = _instrument(fields.get("instrument"))
        if not isinstance(fields.get("raw_metadata"), (dict, list, NoneType)):
            raise TypeError
    except TypeError:
        return _library().InfoModel(**fields).model_dump(exclude_none=True)
    return _known(plain)


def _instrument(fields: Any) -> dict[str, Any] | None:
    """Return the metadata of an instrument; raise `TypeError` unless they have plain types."""
    if fields is None:
        return None
    if type(fields) is not dict:
        raise TypeError
    found = _typed(fields, **dict.fromkeys(_NAMES, str), parameters=dict)
    about = found["parameters"]
    if about is not None:
        found["parameters"] = _known(
            {
                **_typed(about, name=str),
                "resolution": _amount(about.get("resolution")),
                "tip_radius": _amount(about.get("tip_radius")),
            }
        )
    return _known(found)


def _amount(fields: Any) -> dict[str, Any] | None:
    if fields is None:
        return None
    if type(fields) is not dict or type(fields.get("value")) is not float:
        raise TypeError
    return _known(_typed(fields, value=float, unit=str))


def _typed(fields: dict[str, Any], **types: type) -> dict[str, Any]:
    """Return the values of these names; raise `TypeError` for values of another type."""
    found = {name: fields.get(name) for name in types}
    if any(value is not None and type(value) is not types[name] for name, value in found.items()):
        raise TypeError
    return found


def _known(fields: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in fields.items() if value is not None}


def _library() -> Any:
    """Return the module of SurfaceTopography that this module replaces."""
    path = os.path.join(readers.library()[0], "Metadata.py")
    spec = importlib.util.spec_from_file_location(f"{__name__}_library", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
