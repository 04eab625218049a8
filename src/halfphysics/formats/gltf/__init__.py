"""glTF 2.0: animated skeletons, with the meshes around them."""
