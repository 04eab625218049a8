"""Small sweeps, their shards and variants."""
