"""The simulation: from people and a scene to the native core, frame by frame or as a whole."""
