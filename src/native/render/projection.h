// Software z-buffer: from meshes to triangles on the picture.
#pragma once
#include "render/raster.h"

namespace raster {

// Screen triangles of all faces, in face order: culled, clipped to the near plane and to a
// guard band eight pictures wide (which keeps the integers small), projected.
std::vector<Tri> project(const Meshes& m, const Camera& cam);

// Corner normals: area-weighted mean over the faces around the vertex that turn by less than
// the crease angle from the corner's own face.
void compute_normals(Meshes& m);

}  // namespace raster
