"""Contact of two bodies with a pressure ceiling."""
