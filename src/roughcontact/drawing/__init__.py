"""How figures are drawn: style, cells, maps, sections."""
