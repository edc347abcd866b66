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
  model.on("sought", () => setTimeout(() => {
    const place = find(document, "." + model.sought.place);
    if (place == null) return;
    place.scrollIntoView({ block: "nearest" });
    find(place.shadowRoot, "input, select")?.focus();
  }, 100));
  // Text that was typed, but not entered, is sent before the page is left. That message may be
  // lost, as that of text entered a moment ago: after a reload the text is entered again.
  const title = (field) => field.labels?.[0]?.textContent || field.ariaLabel;
  window.addEventListener("beforeunload", () => {
    let at = document.activeElement;
    while (at?.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
    if (at?.matches("input[type=text]"))
      sessionStorage.setItem("typed", JSON.stringify([location.href, title(at), at.value]));
    at?.blur();
  });
  const [page, name, text] = JSON.parse(sessionStorage.getItem("typed") ?? "[]");
  sessionStorage.removeItem("typed");
  const enter = (tries) => {
    const same = findAll(document, "input[type=text]").filter((at) => title(at) == name);
    if (same.length == 0 && tries > 0) setTimeout(() => enter(tries - 1), 200);
    if (same.length != 1 || same[0].value == text) return;
    same[0].value = text;
    same[0].dispatchEvent(new Event("change"));
  };
  if (page == location.href && name) setTimeout(() => enter(25), 500);
  // The class of a field is set where screen readers do not see it.
  const hosts = new WeakSet();
  document.addEventListener("input", (event) => {
    const host = event.composedPath()[0].getRootNode().host;
    if (host == null || hosts.has(host)) return;
    hosts.add(host);
    new MutationObserver(() => host.shadowRoot.querySelector("input, select")
      ?.setAttribute("aria-invalid", host.matches(".invalid"))
    ).observe(host, { attributeFilter: ["class"] });
  });
  // A file is dropped anywhere on the page; areas with another purpose take it first.
  const over = document.createElement("div");
  over.className = "over";
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
