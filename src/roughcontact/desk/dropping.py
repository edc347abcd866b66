"""Where a file is dropped: the browser sends it to the server by itself, with its progress."""

from __future__ import annotations

from typing import ClassVar

import param
from panel.custom import JSComponent

from roughcontact.desk import style

_SCRIPT = """
export function render({ model, el }) {
  const area = document.createElement("label");
  const words = document.createElement("span");
  const input = document.createElement("input");
  const bar = document.createElement("progress");
  area.className = "brought";
  words.textContent = model.words;
  input.type = "file";
  input.setAttribute("aria-label", model.words);
  bar.max = 1;
  bar.hidden = true;
  bar.setAttribute("aria-label", "sent so far");
  area.append(words, input, bar);

  function send(file) {
    const query = new URLSearchParams({ name: file.name });
    const asked = new URLSearchParams(window.location.search);
    for (const name of ["work", "token"]) if (asked.has(name)) query.set(name, asked.get(name));
    const request = new XMLHttpRequest();
    const base = window.location.pathname.replace(/[/]?$/, "/");
    request.open("POST", base + model.address + "?" + query);
    request.upload.onprogress = (at) => { bar.hidden = false; bar.value = at.loaded / at.total; };
    request.onloadend = () => {
      bar.hidden = true;
      input.value = "";
      let told = { error: "the file did not reach the program; is it still running?" };
      try { told = JSON.parse(request.responseText); } catch (error) { }
      model.arrived = { ...told, number: model.count = model.count + 1 };
    };
    request.send(file);
  }
  input.addEventListener("change", () => { if (input.files.length) send(input.files[0]); });
  for (const name of ["dragenter", "dragover"])
    area.addEventListener(name, (event) => { event.preventDefault(); area.classList.add("over"); });
  for (const name of ["dragleave", "drop"])
    area.addEventListener(name, () => area.classList.remove("over"));
  area.addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files.length) send(event.dataTransfer.files[0]);
  });
  return area;
}
"""

_SHEET = f"""
:host {{ border: 0; }}
.brought {{ display: block; border: 1px dashed {style.QUIET}; border-radius: 6px; padding: 10px;
  cursor: pointer; font-family: {style.FONT}; font-size: 13px; color: {style.INK}; }}
.brought:hover, .brought.over, .brought:focus-within {{ border-color: {style.ACCENT};
  background: {style.ACCENT}0d; }}
.brought input {{ display: block; margin-top: 6px; font: inherit; max-width: 100%; }}
.brought progress {{ width: 100%; }}
"""


class Drop(JSComponent):  # type: ignore[misc]
    """An area that takes one file; ``arrived`` is what the server answered, see `receive`."""

    words = param.String("")
    address = param.String("")
    arrived = param.Dict({})
    count = param.Integer(0)

    _esm = _SCRIPT
    _stylesheets: ClassVar = [_SHEET]
