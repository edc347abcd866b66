"""The elastic half-space: arrays in, arrays out."""
