// Software z-buffer: whole pictures.
#pragma once
#include "render/raster.h"
#include "render/shading.h"

namespace raster {

// sRGB bytes (height, width, 3) of meshes, whose normals are computed here, by `threads` threads.
void draw_picture(Meshes& m, const Camera& cam, const Look& look, int threads, unsigned char* out);

// The nearest mesh at each pixel's centre (height, width), -1 for none, and its depth along the
// viewing direction [m], inf for none.
void find_visible(const Meshes& m, const Camera& cam, int* index, double* depth);

}  // namespace raster
