"""A contact that is loaded and unloaded."""
