"""Making of one variant: its scene and motion, its simulation, its sample."""
