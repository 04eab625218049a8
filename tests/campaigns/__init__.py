"""Long campaigns, and tests that run a sample of each."""
