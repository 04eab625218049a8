"""A live server in another process, and clients of all kinds, for tests and campaigns."""
