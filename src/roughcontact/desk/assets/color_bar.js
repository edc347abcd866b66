// The upper half of the color bar moves the upper limit, the lower half the lower one: the value
// under the pointer follows it. The bar is right of the frame, and as high as the frame.
const bar = bars.find((one) => one.visible)
const place = (cb_obj.y - y_range.start) / (y_range.end - y_range.start)
if (cb_obj.event_name == "panstart") {
  const { low, high } = bar?.color_mapper ?? {}
  const inside = bar && cb_obj.x > x_range.end && place >= 0 && place <= 1
  bars.held = inside ? { bar, low, high, value: low + place * (high - low) } : null
}
if (bars.held && cb_obj.event_name == "pan") {
  const { low, high, value } = bars.held, mapper = bars.held.bar.color_mapper
  const at = Math.min(Math.max(place, 0.02), 0.98)
  if (value > (low + high) / 2) mapper.high = low + (value - low) / at
  else {
    const moved = (value - at * high) / (1 - at)
    // A quantity without negative values has none on its scale.
    mapper.low = low < 0 ? moved : Math.max(moved, 0)
  }
}
