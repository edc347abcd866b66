"""Drawing of figures: style, cells, maps, sections."""
