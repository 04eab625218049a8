"""BVH: text of hierarchies with a row of numbers per frame."""
