"""Shapes, triangle meshes and geometric queries."""
