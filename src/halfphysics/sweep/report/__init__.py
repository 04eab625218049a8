"""What came of a sweep: counts, data card, verification."""
