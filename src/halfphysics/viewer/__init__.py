"""Display of results in a browser, live or recorded, with viser."""
