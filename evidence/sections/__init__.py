"""The tables and figures of the paper, one module each, named by its key."""
