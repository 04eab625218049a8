"""People who press themselves into furniture."""
