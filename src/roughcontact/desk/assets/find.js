// Returns the first element that matches, also inside of components; null without one.
function find(root, match) {
  for (const one of root.querySelectorAll("*")) {
    if (one.matches(match)) return one;
    const inner = one.shadowRoot && find(one.shadowRoot, match);
    if (inner) return inner;
  }
  return null;
}
