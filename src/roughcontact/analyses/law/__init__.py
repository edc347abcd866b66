"""Interface law: pressure over separation."""
