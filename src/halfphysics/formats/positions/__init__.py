"""Joint positions become motions, and the readers of files that hold them."""
