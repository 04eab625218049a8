"""What a simulation returns: motion, contacts, depths, and what they were made from."""
