"""Colors and fonts of the page, also for content shown before the import of Panel."""

INK, QUIET, LINE, ACCENT, WARNING = "#14181f", "#525b67", "#dfe3e7", "#0b5cad", "#a6320c"
"""Colors of figures, and of content before or after the page."""

FONT = '-apple-system, "Segoe UI", Roboto, "Noto Sans", "Helvetica Neue", Arial, sans-serif'
