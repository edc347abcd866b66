"""Colors, fonts and scripts of the page, also for content before the import of Panel."""

import re
from pathlib import Path

INK, QUIET, LINE, ACCENT, WARNING = "#14181f", "#525b67", "#dfe3e7", "#0b5cad", "#a6320c"
"""Colors of figures, and of content before or after the page."""

FONT = '-apple-system, "Segoe UI", Roboto, "Noto Sans", "Helvetica Neue", Arial, sans-serif'


_ASSETS = Path(__file__).parent / "assets"


def read_script(*names: str) -> str:
    """Return scripts of the browser, from the files of this package, as one."""
    return "".join((_ASSETS / f"{name}.js").read_text(encoding="utf-8") for name in names)


def read_sheets(**values: str) -> dict[str, str]:
    """Return the style sheets of the page by name, with tokens and some other values."""
    text = (_ASSETS / "page.css").read_text(encoding="utf-8")
    values |= {name: value for name, value in globals().items() if isinstance(value, str)}
    text = re.sub(r"\$([A-Z]+)", lambda name: values[name[1]], text)
    parts = re.split(r"/\* ([A-Z_]+) \*/", text)
    return dict(zip(parts[1::2], parts[2::2], strict=True))
