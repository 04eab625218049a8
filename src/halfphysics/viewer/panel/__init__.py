"""The panel of the playground: choice, playing, knobs and status."""
