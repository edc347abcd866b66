export function render({ model }) {
  const list = document.createElement("div");
  list.setAttribute("role", "tablist");
  list.className = model.pictured ? "pictured" : "";
  const images = [];
  const turn = (place) => {
    if (place == model.active) return;
    // The panel takes no click until the server has sent the next one.
    const body = model.body && find(document, "." + model.body);
    for (const panel of body?.shadowRoot?.children ?? []) {
      panel.inert = true;
      panel.style.opacity = 0.5;
    }
    model.active = place;
  };
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
    tab.addEventListener("click", () => turn(place));
    list.append(tab);
    return tab;
  });
  const steps = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 };
  list.addEventListener("keydown", (event) => {
    if (!(event.key in steps)) return;
    event.preventDefault();
    turn((model.active + steps[event.key] + tabs.length) % tabs.length);
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
