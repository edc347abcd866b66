// Only numbers and fixed texts: no content of a file enters the markup.
const {x, y} = cb_obj
const at = (source, name) => {
  const data = source.data
  if (data[name] == null || data[name].length == 0) return null
  const image = data[name][0], [ny, nx] = image.shape
  const j = Math.floor((x - data.x[0]) / data.dw[0] * nx)
  const i = Math.floor((y - data.y[0]) / data.dh[0] * ny)
  return i < 0 || j < 0 || i >= ny || j >= nx ? null : image[i * nx + j]
}
const show = (value, unit) =>
  value == null || Number.isNaN(value) ? "–" : `${Number(value.toPrecision(4))} ${unit}`
const share = (value) => `${Number((100 * value).toPrecision(3))} %`
if (heights.data.display.length == 0) return
const display = heights.data.display[0], [by, bx] = display.cell, exact = by == 1 && bx == 1
const value = (source, name) => show(at(source, name), source.data.display[0]?.unit)
const rows = [
  ["x, y", `${Number(x.toPrecision(5))}, ${Number(y.toPrecision(5))} ${display.length}`],
  [exact ? "height" : "mean height", value(heights, "heights")],
]
if (contact.data.display.length) {
  const touching = at(contact, "touching"), saturated = at(contact, "saturated")
  const missing = at(contact, "missing")
  rows.push([exact ? "pressure" : "largest pressure", value(pressure, "pressure")],
            [exact ? "gap" : "mean open gap", value(gap, "gap")],
            [exact ? "indentation" : "deepest indentation", value(residual, "residual")])
  let state = "–"
  if (touching != null) {
    if (exact) {
      state = saturated ? "saturated" : touching ? "elastic" : missing ? "missing" : "open"
    } else {
      state = `${share(touching)} touching`
      if (saturated) state += `, ${share(saturated)} saturated`
    }
  }
  rows.push(["contact", state])
}
const lines = rows.map(([name, text]) =>
  `<tr><td class="quiet">${name}</td><td>${text}</td></tr>`).join("")
const note = exact ? "one cell is one point" : `one cell is ${by} × ${bx} points (y × x)`
div.text = `<table>${lines}</table><div class="quiet">${note}</div>`
