"""Take the screenshots of the app, and write the part of its how-to page that shows them.

    python docs/pages.py FOLDER

Without a browser, that part states so.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path += [str(Path(__file__).parents[1] / name) for name in ("benchmarks", "calibration")]

from browsing import Seat, Served, browser, lacking

_DRAWN = """() => new Promise((done) => setTimeout(
  () => requestAnimationFrame(() => requestAnimationFrame(done)), 500))"""

WIDTH, HEIGHT = 1440, 900


def show_contact(seat: Any) -> None:
    """Show a contact with its section."""
    seat.choose("Or a demonstration map", "Ground steel")
    seat.page.locator("p > b").get_by_text("Ground steel.npz", exact=True).wait_for()
    seat.choose("Material", "100Cr6")
    seat.choose("Boundary", "a sample of")
    seat.type("Value with unit", "100 MPa")
    seat.page.get_by_text("converged, certificate").wait_for()


def show_relief(seat: Any) -> None:
    """Show the heights with their pressure."""
    seat.turn("3-D")
    seat.page.locator(".scene").wait_for()


def show_analysis(seat: Any) -> None:
    """Show an analysis."""
    seat.turn("Analyze")
    seat.page.get_by_role("button", name="Start").click()
    seat.page.get_by_text("Done in").wait_for()
    seat.page.locator("img.figure").locator("visible=true").first.wait_for()


def show_joint(seat: Any) -> None:
    """Show the analyses of a joint."""
    seat.turn("Joint")
    seat.page.get_by_label("Interface law").wait_for()
    seat.page.get_by_role("button", name="Start").locator("visible=true").click()
    seat.page.get_by_text("Done in").locator("visible=true").wait_for()
    seat.page.locator("img.figure").locator("visible=true").first.wait_for()


def show_export(seat: Any) -> None:
    """Show the same contact as command, script and project file."""
    seat.turn("Export")
    seat.page.locator("pre").first.wait_for()


PICTURES: dict[str, tuple[Callable[[Any], None], str]] = {
    "desk": (
        show_contact,
        "A ground map under 100 MPa: numbers, messages, linked maps and a section",
    ),
    "desk-relief": (show_relief, "3-D: the heights with the pressure on them"),
    "desk-ask": (show_analysis, "Analyze: the load curve of the same contact"),
    "desk-joint": (show_joint, "Joint: estimate and interface law, with files"),
    "desk-take": (show_export, "Export: a page to send, command, script and project file"),
}
"""What is done before a picture, one after the other, and what the picture shows."""

NOTE = "*The pictures of this page are taken by Chromium, which was not there when it was built.*\n"


def main(folder: Path) -> None:
    """Write the pictures and the part of the page."""
    text = NOTE
    if not lacking():
        with tempfile.TemporaryDirectory() as works, browser() as started:
            served = Served(Path(works))
            try:
                seat = Seat(started, served.home, WIDTH, HEIGHT)
                for name, (act, _) in PICTURES.items():
                    act(seat)
                    seat.page.wait_for_load_state("networkidle")
                    # What came last is drawn by the frame after the next.
                    seat.page.evaluate(_DRAWN)
                    seat.page.screenshot(path=folder / f"{name}.png")
            finally:
                served.kill()
        text = "\n".join(
            f"```{{figure}} ../generated/{name}.png\n:alt: {words}\n\n{words}.\n```\n"
            for name, (_, words) in PICTURES.items()
        )
    (folder / "desk.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
