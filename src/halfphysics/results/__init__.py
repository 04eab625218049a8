"""Results of a simulation: motion, contacts, depths, and records of their inputs."""
