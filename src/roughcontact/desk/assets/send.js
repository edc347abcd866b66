// Sends a file to the server; ``arrived`` of the model is the response.
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
    let answer = { error: "the file did not reach the program; is it still running?" };
    try { answer = JSON.parse(request.responseText); } catch (error) { }
    model.arrived = { ...answer, number: model.count = model.count + 1 };
  };
  request.send(file);
}
