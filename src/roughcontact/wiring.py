"""What the ground floor asks of the wings above, connected when the package is imported."""

from roughcontact import result


def _face() -> result.Face:
    from roughcontact import face

    return face


result.connect(_face)
