"""What `campaigns.ground` runs and measures: cases, figures of a result, limits."""
