import json
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from roughcontact.surface import nominal_bodies
from roughcontact.surface.provenance import NOTE, Operation, Provenance, from_text, to_text
from roughcontact.surface.surface import Surface

PIXEL = (2e-6, 3e-6)
READING = Operation(
    "read_surface",
    {"path": "a.txt", "format": None, "channel": None, "unit": "um", "size": np.array([1e-3, 0.1])},
    {"format": "text", "notes": ("read: the last row has no line end",)},
)
LEVELED = Operation(
    "leveled", {"form": "three-point", "points": [[0, 0], [0, 3], [np.int64(2), 1]]}
)


def test_steps_are_stored_and_formatted() -> None:
    about = Provenance("a.txt", "matrix (text)", origin=READING).then(LEVELED)
    assert about.operations == (LEVELED,)
    assert about.steps == (
        "read: the last row has no line end",
        "leveled: plane through the points (0, 0), (0, 3), (2, 1) subtracted",
    )
    assert about.in_words().startswith("a.txt (read: the last row has no line end; leveled: plane")
    assert (Provenance().in_words(), Provenance("b").in_words()) == ("another map", "b")


def test_arguments_are_python_s_own() -> None:
    assert LEVELED.arguments["points"] == ((0, 0), (0, 3), (2, 1))
    assert all(type(y) is int for pair in LEVELED.arguments["points"] for y in pair)
    assert READING.arguments["size"] == (1e-3, 0.1)
    assert type(READING.arguments["size"][1]) is float


def test_sentences_of_others_are_notes() -> None:
    about = Provenance("ball", steps=("polished: by hand", "etched"))
    assert [step.method for step in about.operations] == [NOTE, NOTE]
    assert about.steps == ("polished: by hand", "etched")
    assert about == Provenance("ball", operations=map(Operation.note, about.steps))


def test_array_has_provenance_after_first_step() -> None:
    surface = Surface(np.eye(5), PIXEL, Provenance("eye"))
    assert surface.provenance.origin is None
    origin = surface.leveled().filled().cropped((0, 3), (0, 4)).provenance.origin
    assert origin == Operation(
        "Surface", {"pixel": PIXEL, "holes_masked": False}, {"shape": (5, 5)}
    )
    assert surface.traced() == replace(surface.provenance, origin=origin)


def test_added_form_is_kept_as_its_operation() -> None:
    surface = Surface(np.zeros((9, 9)), PIXEL)
    ball = nominal_bodies.sphere(radius=1e-3, shape=(9, 9), pixel=PIXEL, center=(3, 4.5))
    step = surface.with_form(ball.rotated(180)).provenance.operations[-1]
    assert step.arguments["form"].origin.arguments == {
        "radius": 1e-3,
        "shape": (9, 9),
        "pixel": PIXEL,
        "center": (3, 4.5),
    }
    assert step.sentences == (
        "form added: nominal sphere of radius 1 mm (placed at the point (3, 4.5) (y, x) in pixels; "
        "rotated: 180 degrees counter-clockwise, row 0 on top)",
    )
    one, other = (surface.with_form(Surface(np.full((9, 9), z), PIXEL)) for z in (0.0, 1.0))
    known = [sum_.provenance.operations[-1].arguments["form"].origin for sum_ in (one, other)]
    assert known[0].found["sha256"] != known[1].found["sha256"]
    assert known[0].found["shape"] == (9, 9)


def provenance_of_every_step() -> Provenance:
    surface = Surface(np.arange(80.0).reshape(8, 10) ** 2 * 1e-9, PIXEL, Provenance("a", "b", "c"))
    ball = nominal_bodies.sphere(radius=1 / 3, shape=(8, 10), pixel=PIXEL)
    made = surface.leveled().with_form(ball).aligned(surface, (1e-6 / 3, 0), 12.5).filled()
    return replace(made.provenance, source="gr\udcfcn\n\u2028.opd")


def test_a_provenance_survives_as_text() -> None:
    about = provenance_of_every_step()
    text = to_text(about)
    assert text.isascii()
    again = from_text(text)
    assert again == about
    assert again.steps == about.steps
    assert hash(again) == hash(about)
    assert pickle.loads(pickle.dumps(about)) == about


def changed_record(change: Any) -> str:
    record = json.loads(to_text(provenance_of_every_step()))
    change(record)
    return json.dumps(record)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        "3",
        changed_record(lambda r: r.update(version=99)),
        changed_record(lambda r: r.pop("source")),
        changed_record(lambda r: r["operations"][0].update(method="polished")),
        changed_record(lambda r: r["operations"][0].pop("found")),
        changed_record(lambda r: r["operations"][0]["arguments"].pop("form")),
        changed_record(lambda r: r["operations"][0]["arguments"].update({"x=exit()": 1})),
        changed_record(lambda r: r["operations"][1]["arguments"].update(form=None)),
        changed_record(lambda r: r["operations"][2]["found"].update(smoothing=[1.0])),
        changed_record(lambda r: r["origin"].update(method="leveled")),
        changed_record(lambda r: r["origin"]["found"].update(shape="many")),
        changed_record(lambda r: r["origin"]["found"].pop("shape")),
        changed_record(lambda r: r["origin"]["arguments"].pop("pixel")),
        changed_record(lambda r: r["origin"].update(method="read_surface")),
    ],
)
def test_damaged_text_raises_value_error(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 - of json or of ours
        from_text(text)
