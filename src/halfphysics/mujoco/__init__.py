"""A person in a MuJoCo world that another program steps."""
