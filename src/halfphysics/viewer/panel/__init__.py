"""The panel of the playground: what to play, how, and how well the machine keeps up."""
