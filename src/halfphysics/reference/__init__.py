"""The substep in plain numpy: slow, readable, and equal to the native core."""
