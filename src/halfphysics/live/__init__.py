"""Live: poses of people who move now come in, corrected poses, objects and contacts go out."""
