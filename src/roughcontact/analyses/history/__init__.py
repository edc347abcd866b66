"""Loading and unloading of a contact."""
