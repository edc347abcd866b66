"""Contact with plasticity of the volume."""
