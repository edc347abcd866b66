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
