from types import SimpleNamespace

from roughcontact.analyses.solve import fields
from roughcontact.report.kind import quantity_of


def test_large_contact_area_has_a_thousands_separator() -> None:
    result = SimpleNamespace(contact_area=1.173e-8, contact_fraction=0.047)
    text = quantity_of(fields.CONTACT, "contact_area").text
    assert text is not None
    assert text(result).startswith("11,730 µm² (")
