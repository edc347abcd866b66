"""Tangential loading: stick, slip and fretting."""
