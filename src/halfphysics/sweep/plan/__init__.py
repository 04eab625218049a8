"""What a sweep is to do: axes, factors, values, conditions, numbered variants."""
