"""The work of a sweep is done here: driver, local processes, Ray."""
