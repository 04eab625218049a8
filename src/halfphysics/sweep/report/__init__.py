"""Reports on a sweep: summary and verification."""
