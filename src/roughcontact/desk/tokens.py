"""Colors, fonts and scripts of the page, also for content before the import of Panel."""

from pathlib import Path

INK, QUIET, LINE, ACCENT, WARNING = "#14181f", "#525b67", "#dfe3e7", "#0b5cad", "#a6320c"
"""Colors of figures, and of content before or after the page."""

FONT = '-apple-system, "Segoe UI", Roboto, "Noto Sans", "Helvetica Neue", Arial, sans-serif'


def read_script(*names: str) -> str:
    """Return scripts of the browser, from the files of this package, as one."""
    folder = Path(__file__).parent / "scripts"
    return "".join((folder / f"{name}.js").read_text(encoding="utf-8") for name in names)
