"""Shared by the tests: people, scenes, files, and judges that examine a run from outside."""
