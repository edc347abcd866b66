"""One contact."""
