"""Widgets for keyboards and screen readers, where those of Bokeh need a pointer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import panel as pn
import param
from bokeh.events import ConnectionLost, DocumentReady
from bokeh.models import CustomJS
from panel.custom import JSComponent

from roughcontact.desk import style, tokens

# Sends a file to the server; ``arrived`` of the model is the response.
_SEND = """
function send(model, file, show) {
  const query = new URLSearchParams({ name: file.name });
  const asked = new URLSearchParams(window.location.search);
  for (const name of ["work", "token"]) if (asked.has(name)) query.set(name, asked.get(name));
  const request = new XMLHttpRequest();
  const base = window.location.pathname.replace(/[/]?$/, "/");
  request.open("POST", base + "upload?" + query);
  request.upload.onprogress = (at) => show(at.loaded / at.total);
  request.onloadend = () => {
    show(null);
    let told = { error: "the file did not reach the program; is it still running?" };
    try { told = JSON.parse(request.responseText); } catch (error) { }
    model.arrived = { ...told, number: model.count = model.count + 1 };
  };
  request.send(file);
}
"""

_SCRIPT = (
    _SEND
    + """
export function render({ model }) {
  const area = document.createElement("label");
  const words = document.createElement("span");
  const input = document.createElement("input");
  const bar = document.createElement("progress");
  area.className = "brought";
  words.textContent = model.words;
  input.type = "file";
  input.setAttribute("aria-label", model.words);
  bar.hidden = true;
  bar.setAttribute("aria-label", "sent so far");
  area.append(words, input, bar);
  const show = (share) => {
    bar.hidden = share == null;
    if (share == null) input.value = "";
    else bar.value = share;
  };
  input.addEventListener("change", () => {
    if (input.files.length) send(model, input.files[0], show);
  });
  for (const name of ["dragenter", "dragover"])
    area.addEventListener(name, (event) => { event.preventDefault(); area.classList.add("over"); });
  for (const name of ["dragleave", "drop"])
    area.addEventListener(name, () => area.classList.remove("over"));
  area.addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files.length) send(model, event.dataTransfer.files[0], show);
  });
  return area;
}
"""
)

_SHEET = f"""
:host {{ border: 0; }}
.brought {{ display: block; border: 1px dashed var(--muted); border-radius: 6px; padding: 10px;
  cursor: pointer; font-family: {tokens.FONT}; font-size: 13px; color: var(--text); }}
.brought:hover, .brought.over, .brought:focus-within {{ border-color: var(--accent);
  background: var(--accent-weak); }}
.brought input {{ display: block; margin-top: 6px; font: inherit; max-width: 100%; }}
.brought progress {{ width: 100%; }}
"""


class FileDrop(JSComponent):  # type: ignore[misc]
    """Upload area for one file; ``arrived`` is the response of the server."""

    words = param.String("")
    arrived = param.Dict({})
    count = param.Integer(0)

    _esm = _SCRIPT
    _stylesheets: ClassVar = [_SHEET]


# Widgets for keyboards and screen readers, where those of Bokeh need a pointer


LOST = (
    "The program has ended, or cannot be reached. The project is saved: start the program again, "
    "and reload this page."
)

BROKEN = "This page shows an old state. Reload it."

_STRIP = """
export function render({ model }) {
  const list = document.createElement("div");
  list.setAttribute("role", "tablist");
  list.className = model.pictured ? "pictured" : "";
  const images = [];
  const tabs = model.names.map((name, place) => {
    const tab = document.createElement("button");
    tab.type = "button";
    tab.setAttribute("role", "tab");
    if (model.pictured) {
      images.push(document.createElement("img"));
      images[place].alt = "";
      tab.append(images[place]);
    }
    tab.append(name);
    tab.addEventListener("click", () => { model.active = place; });
    list.append(tab);
    return tab;
  });
  const steps = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 };
  list.addEventListener("keydown", (event) => {
    if (!(event.key in steps)) return;
    event.preventDefault();
    model.active = (model.active + steps[event.key] + tabs.length) % tabs.length;
    tabs[model.active].focus();
  });
  const show = () => tabs.forEach((tab, place) => {
    tab.setAttribute("aria-selected", place == model.active);
    tab.tabIndex = place == model.active ? 0 : -1;
  });
  const draw = () => images.forEach((image, place) => {
    image.hidden = !model.pictures[place];
    if (!image.hidden) image.src = model.pictures[place];
  });
  const fit = () => list.style.setProperty("--side", `${model.side}px`);
  model.on("active", show);
  model.on("pictures", draw);
  model.on("side", fit);
  show();
  draw();
  fit();
  return list;
}
"""

_STRIP_SHEET = f"""
div {{ display: flex; gap: 2px; width: 100%; height: 100%; }}
button {{ font-family: {tokens.FONT}; font-size: 13px; color: var(--text); background: none;
  border: 0; border-bottom: 2px solid transparent; padding: 7px 10px; cursor: pointer; }}
button:hover {{ background: var(--sunken); }}
button[aria-selected=true] {{ border-color: var(--accent); font-weight: 600; }}
button:focus-visible {{ outline: 2px solid var(--accent); outline-offset: -2px; }}
.pictured {{ display: grid; grid-template-columns: var(--side); gap: 8px; width: auto;
  align-content: start; }}
.pictured button {{ padding: 0 0 4px; text-align: left; font-size: 11px; white-space: nowrap; }}
img {{ display: block; width: var(--side); max-height: var(--side); object-fit: contain;
  object-position: top left; }}
[hidden] {{ display: none; }}
"""

_SLIDER = """
export function render({ model }) {
  const area = document.createElement("div");
  const input = document.createElement("input");
  const shown = document.createElement("output");
  const marks = document.createElement("div");
  input.type = "range";
  input.min = 0;
  input.setAttribute("aria-label", model.words);
  input.title = model.words;
  shown.setAttribute("aria-hidden", true);
  let drags = false, count = 0;
  const place = (part) => `calc(8px + ${part} * (100% - 16px))`;
  const show = () => {
    const at = input.valueAsNumber, none = model.value < 0 && !drags;
    const given = at == model.value && model.text;
    const text = none ? "no load so far" : given || (model.texts[at] ?? "");
    input.className = none ? "none" : "";
    input.setAttribute("aria-valuetext", text);
    shown.textContent = text;
    shown.style.left = place(at / (input.max || 1));
  };
  const put = () => {
    input.max = model.end;
    input.disabled = shown.hidden = model.texts.length == 0;
    if (!drags) input.value = model.value < 0 ? model.end / 2 : model.value;
    show();
  };
  const rule = () => marks.replaceChildren(...model.ticks.map(([part, text]) => {
    const mark = document.createElement(text ? "b" : "i");
    mark.textContent = text;
    mark.style.left = place(part);
    return mark;
  }));
  const tell = (done) => {
    model.moved = { value: input.valueAsNumber, done, count: count = count + 1 };
  };
  input.addEventListener("pointerdown", () => { drags = true; });
  input.addEventListener("input", () => {
    show();
    input.className = "";
    if (drags) tell(false);
  });
  input.addEventListener("change", () => { drags = false; tell(true); });
  input.addEventListener("pointerup", () => { drags = false; });
  model.on(["value", "text", "texts"], put);
  model.on("ticks", rule);
  put();
  rule();
  area.append(input, shown, marks);
  return area;
}
"""

_SLIDER_SHEET = f"""
:host > div {{ position: relative; height: 54px; width: 100%; font: 11px/14px {tokens.FONT}; }}
input {{ position: absolute; top: 18px; left: 0; width: 100%; margin: 0; height: 16px;
  accent-color: var(--accent); cursor: pointer; }}
input.none::-webkit-slider-thumb {{ visibility: hidden; }}
input.none::-moz-range-thumb {{ visibility: hidden; }}
input.none + output {{ background: none; color: var(--muted); font-weight: 400; }}
output {{ position: absolute; top: -1px; transform: translateX(-50%); padding: 1px 6px;
  border-radius: 3px; font-weight: 600; white-space: nowrap; background: var(--text);
  color: var(--surface); }}
i, b {{ position: absolute; top: 36px; font-weight: 400; white-space: nowrap; color: var(--muted);
  transform: translateX(-50%); }}
i {{ width: 1px; height: 4px; background: var(--control); }}
b::before {{ content: ""; display: block; width: 1px; height: 5px; margin: 0 auto;
  background: var(--control); }}
"""


class TabStrip(JSComponent):  # type: ignore[misc]
    """Strip of tabs; ``active`` is the index of the active tab.

    If ``pictured``, each tab has a thumbnail: a URL in ``pictures``, ``side`` dots wide and high.
    """

    names = param.List([])
    active = param.Integer(0)
    pictured = param.Boolean(False)
    pictures = param.List([])
    side = param.Integer(0)

    _esm = _STRIP
    _stylesheets: ClassVar = [_STRIP_SHEET]


class Tabs:
    """Tabs that build only the active panel."""

    def __init__(
        self, parts: Mapping[str, Any], turned: Callable[[], None], sizing: str = "stretch_width"
    ) -> None:
        about = {**style.TABS, "sizing_mode": sizing}
        self._parts, self._turned = list(parts.values()), turned
        self.strip = TabStrip(names=list(parts), **style.STRIP)
        self.body = pn.Column(**about)
        self.strip.param.watch(lambda _: self._turn(), "active")
        self._update_body()

    @property
    def active(self) -> int:
        """Index of the active panel."""
        return int(self.strip.active)

    def _update_body(self) -> None:
        self.body[:] = [self._parts[self.active]]

    def _turn(self) -> None:
        self._update_body()
        self._turned()


class Slider(JSComponent):  # type: ignore[misc]
    """Slider with a scale and a text for each position; reports each move in ``moved``.

    ``text`` is the text of the current value, which may be between two positions. Before a value
    is given, ``value`` is -1: the slider has no thumb.
    """

    words = param.String("")
    end = param.Integer(1)
    value = param.Integer(-1)
    text = param.String("")
    texts = param.List([])
    ticks = param.List([])
    moved = param.Dict({})

    # Delay of a value for a later one [ms]: the default of 50 is half the time of a step.
    _debounce: ClassVar[int] = 5
    _esm = _SLIDER
    _stylesheets: ClassVar = [_SLIDER_SHEET]


_FRAME = (
    _SEND
    + """
export function render({ model }) {
  const tell = () => { model.size = [window.innerWidth, window.innerHeight]; };
  const scheme = window.matchMedia("(prefers-color-scheme: dark)");
  const color = () => { model.dark = scheme.matches; };
  scheme.addEventListener("change", color);
  color();
  let waits = 0, count = 0;
  window.addEventListener("resize", () => {
    clearTimeout(waits);
    waits = setTimeout(tell, 150);
  });
  tell();
  document.addEventListener("keydown", (event) => {
    const at = event.composedPath()[0];
    const kinds = ["range", "checkbox", "radio", "file"];
    const typing = at.matches?.("input, select, textarea") && !kinds.includes(at.type);
    const held = event.ctrlKey || event.metaKey;
    let name = event.key;
    if (held && name.toLowerCase() == "z") name = event.shiftKey ? "redo" : "undo";
    else if (held || event.altKey || !/^([1-5?]|Escape)$/.test(name)) return;
    if (typing && name != "Escape") return;
    event.preventDefault();
    model.key = { name, count: count = count + 1 };
  });
  const find = (root, match) => {
    for (const one of root.querySelectorAll("*")) {
      if (one.matches(match)) return one;
      const inner = one.shadowRoot && find(one.shadowRoot, match);
      if (inner) return inner;
    }
    return null;
  };
  model.on("sought", () => setTimeout(() => {
    const place = find(document, "." + model.sought.place);
    if (place == null) return;
    place.scrollIntoView({ block: "nearest" });
    find(place.shadowRoot, "input, select")?.focus();
  }, 100));
  // Text that was typed, but not entered, is sent before the page is left.
  window.addEventListener("beforeunload", () => {
    let at = document.activeElement;
    while (at?.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
    at?.blur();
  });
  // A file is dropped anywhere on the page; areas with another purpose take it first.
  const over = document.createElement("div");
  over.textContent = "Drop the height map";
  over.hidden = true;
  const carries = (event) => event.dataTransfer?.types.includes("Files");
  document.addEventListener("dragover", (event) => {
    if (!carries(event)) return;
    over.hidden = event.defaultPrevented;
    event.preventDefault();
  });
  document.addEventListener("dragleave", (event) => {
    if (event.relatedTarget == null) over.hidden = true;
  });
  document.addEventListener("drop", (event) => {
    over.hidden = true;
    if (!carries(event) || event.defaultPrevented) return;
    event.preventDefault();
    send(model, event.dataTransfer.files[0], () => {});
  });
  return over;
}
"""
)

_FRAME_SHEET = f"""
div {{ position: fixed; inset: 0; z-index: 30; pointer-events: none; display: grid;
  place-items: center; font: 600 18px {tokens.FONT}; color: var(--accent);
  background: color-mix(in srgb, var(--accent-weak) 80%, transparent);
  outline: 3px dashed var(--accent); outline-offset: -12px; }}
[hidden] {{ display: none; }}
"""


class Frame(JSComponent):  # type: ignore[misc]
    """Browser window: size, color scheme, pressed key, dropped file; ``sought`` gets the focus."""

    size = param.List([1280, 800])
    dark = param.Boolean(False)
    key = param.Dict({})
    sought = param.Dict({})
    arrived = param.Dict({})
    count = param.Integer(0)

    _esm = _FRAME
    _stylesheets: ClassVar = [_FRAME_SHEET]


def send_all_after_pull(document: Any) -> None:
    """Send also changes between the copy of a document and its first rendering."""
    copied = document.to_json

    def copy(*more: Any, **named: Any) -> Any:
        created = copied(*more, **named)
        pn.state._connected[document] = True
        return created

    document.to_json = copy


def reload_when_broken(document: Any) -> None:
    """Reload a page that cannot apply a change; after a second failure, show a message."""
    document.js_on_event(DocumentReady, CustomJS(args={"words": BROKEN}, code=_BROKEN))


def tell_when_lost(document: Any) -> None:
    """Show a message on the page after the loss of its server."""
    document.js_on_event(ConnectionLost, CustomJS(args={"words": LOST}, code=_LOST))


_LOST = f"""
if (document.getElementById("lost") == null) {{
  const said = document.createElement("div")
  said.id = "lost"
  said.setAttribute("role", "alert")
  said.textContent = words
  said.style.cssText = `position: fixed; z-index: 1000; inset: 0 0 auto 0; padding: 10px 16px;
    background: {tokens.WARNING}; color: white; font: 14px {tokens.FONT}`
  document.body.append(said)
}}
"""

_BROKEN = f"""
const again = 60000
for (const page of Bokeh.documents) {{
  const apply = page.apply_json_patch.bind(page)
  page.apply_json_patch = (...patch) => {{
    // What the server sends is not new to it: Bokeh would send it back whole with the next event.
    const own = new Set(page._new_models)
    try {{
      apply(...patch)
      page._new_models = own
    }} catch (error) {{
      const last = Number(sessionStorage.getItem("broken"))
      sessionStorage.setItem("broken", Date.now())
      if (Date.now() - last > again) location.reload()
      else {{ {_LOST} }}
      throw error
    }}
  }}
}}
"""


# --- Tabs whose panels are built when first shown ---


class TabPanel:
    """Panel of a tab."""

    root: Any
    """Content of the panel."""

    _working: Any = None
    """Button of the job, a `controls.JobButton`; None without a job."""

    def refresh(self) -> None:
        """Update the panel; called after each change while it is visible."""

    def cancel(self) -> None:
        """Cancel the running job."""
        if self._working is not None:
            self._working.cancel()


class TabPanels:
    """Tabs of the page: the first panel is given, the others are built when first shown."""

    def __init__(self, first: Any, others: Mapping[str, Callable[[], TabPanel]]) -> None:
        self._makers = list(others.values())
        self._created: dict[int, TabPanel] = {}
        self._places = [
            pn.Column(sizing_mode="stretch_both", margin=0, stylesheets=[style.VIEW])
            for _ in others
        ]
        parts = {"Contact": first, **dict(zip(others, self._places, strict=True))}
        self._tabs = Tabs(parts, self.refresh, "stretch_both")
        self.strip, self.body = self._tabs.strip, self._tabs.body

    def refresh(self) -> None:
        """Update the visible panel."""
        active = self._tabs.active
        if active == 0:
            return
        if active not in self._created:
            self._created[active] = created = self._makers[active - 1]()
            self._places[active - 1].append(created.root)
        self._created[active].refresh()

    def close(self) -> None:
        """Cancel the running jobs of all panels."""
        for view in self._created.values():
            view.cancel()
