"""The page in the browser: a map, two bodies and a load, and the contact that follows them."""
