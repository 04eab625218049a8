"""What stands around and lies in hands in the scenarios."""
