"""The folder of a sweep: fragments, shards, records."""
