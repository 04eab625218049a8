"""The computations of the sections: motions followed, scenarios simulated, and their measures."""
