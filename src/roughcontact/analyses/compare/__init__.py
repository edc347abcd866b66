"""Comparison of groups of maps, and sampling error of a map."""
