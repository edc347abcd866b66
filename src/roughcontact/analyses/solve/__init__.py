"""Solution of one contact."""
