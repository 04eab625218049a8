"""People who press into furniture."""
