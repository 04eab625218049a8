"""What the sections run: motions followed, scenarios played, and what is measured of them."""
