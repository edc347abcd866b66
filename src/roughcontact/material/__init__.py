"""Materials: constants, hardening, hardness, catalogue."""
