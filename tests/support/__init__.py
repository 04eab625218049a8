"""What the tests share: people, scenes, files, and judges that look at a run from outside."""
