"""Shapes and meshes, and questions to them."""
