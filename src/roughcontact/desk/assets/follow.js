// The line follows the handles in the browser; the server receives the change later.
const data = source.data
const x = ends.map((end) => (end.left + end.right) / 2)
const y = ends.map((end) => (end.top + end.bottom) / 2)
const moved = x.some((value, i) => Math.abs(value - data.x[i]) > 1e-9)
  || y.some((value, i) => Math.abs(value - data.y[i]) > 1e-9)
if (data.x.length == 2 && moved) source.data = {...data, x, y}
