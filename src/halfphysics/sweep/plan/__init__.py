"""The plan of a sweep: axes, factors, values, conditions, numbered variants."""
