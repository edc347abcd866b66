// Returns all elements that match, also inside of components.
function findAll(root, match) {
  return [...root.querySelectorAll("*")].flatMap((one) => [
    ...(one.matches(match) ? [one] : []),
    ...(one.shadowRoot ? findAll(one.shadowRoot, match) : [])]);
}
// Returns the first of them; null without one.
function find(root, match) {
  return findAll(root, match)[0] ?? null;
}
