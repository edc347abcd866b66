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
