"""What is around a person: static geometry, objects, articulated and kinematic items."""
