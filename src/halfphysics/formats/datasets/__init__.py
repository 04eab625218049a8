"""Data sets of human motion and objects, one module per layout."""
