"""Browser app: map, bodies and load of a contact, and its live results."""
