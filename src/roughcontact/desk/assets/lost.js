// Shows a message at the top of the page, once.
function show_lost(words) {
  if (document.getElementById("lost") != null) return
  const said = document.createElement("div")
  said.id = "lost"
  said.setAttribute("role", "alert")
  said.textContent = words
  said.style.cssText = `position: fixed; z-index: 1000; inset: 0 0 auto 0; padding: 10px 16px;
    background: $WARNING; color: white; font: 14px $FONT`
  document.body.append(said)
}
