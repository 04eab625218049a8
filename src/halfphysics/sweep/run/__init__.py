"""Running a sweep: driver, local processes, Ray."""
