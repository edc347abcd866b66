"""What a joint does, of contacts that are solved: how well it conducts."""
