"""Results made by hand."""
