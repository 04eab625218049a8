"""Files of other programs and data sets, made up, and readers of them."""
