"""Maps of heights: preparation, parameters, shapes."""
