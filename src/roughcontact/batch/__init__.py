"""Batch runs: the contacts of a project file on several processes or machines."""
