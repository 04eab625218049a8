"""A person's shape: skin, mass, rigid parts, skin hulls, strength."""
