"""Who does the work of a sweep: driver, local processes, Ray."""
