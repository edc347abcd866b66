"""Contact of two bodies under a ceiling of the pressure."""
