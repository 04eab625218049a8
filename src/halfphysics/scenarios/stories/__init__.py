"""The built-in scenarios, one module each."""
