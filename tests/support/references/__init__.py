"""Fast paths of the package once more, slowly, in plain numpy: tests hold both equal."""
