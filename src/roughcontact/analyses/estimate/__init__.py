"""A contact by formulas."""
