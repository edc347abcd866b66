"""Comparison and interruption of runs of the elastoplastic model."""

from dataclasses import fields

import numpy as np

from roughcontact.elastoplastic.volume_result import ElastoplasticResult


def bits(result: ElastoplasticResult) -> dict[str, object]:
    """Return all that a result says but the time it took."""
    held: dict[str, object] = {
        "increments": result.increments,
        "status": result.status,
        "excess": result.yield_excess,
        "displacement": result.residual_displacement.tobytes(),
    }
    parts = {"contact": result.contact}
    parts |= {f"body {number}": body for number, body in enumerate(result.bodies)}
    for name, part in parts.items():
        for field in fields(part):
            value = getattr(part, field.name)
            if isinstance(value, np.ndarray):
                held[f"{name} {field.name}"] = (value.dtype, value.shape, value.tobytes())
            elif isinstance(value, (int, float, str)) and field.name != "seconds":
                held[f"{name} {field.name}"] = value
    return held


class StopError(Exception):
    pass
