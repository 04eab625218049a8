// Many points against one tree of triangles (triangle_tree.h), by several threads.
//
// Any number of threads gives the same bits, as every point is answered on its own. Points are
// (n, 3) [m].
#pragma once
#include <cstddef>
#include <cstdint>

#include "geometry/triangle_tree.h"

namespace triangles {

// Distances (n,) [m], nearest faces (n,) and closest points (n, 3) [m].
void closest_points(const Tree& tree, const double* points, size_t n, int threads, double* distance,
                    int* face, double* closest);

// Signed crossings (n,) of the rays upward: the winding number of closed triangles.
void crossings(const Tree& tree, const double* points, size_t n, int threads, int* out);

// Generalised winding numbers (n,), off by at most `tolerance`; 0: the full sum.
void winding_numbers(const Tree& tree, const double* points, size_t n, double tolerance,
                     int threads, double* out);

// 1 where the winding number is over its own threshold (n,), else 0: as the full sum would say.
// Neighbouring points with one threshold are decided together.
void exceeds(const Tree& tree, const double* points, size_t n, const double* threshold, int threads,
             uint8_t* out);

}  // namespace triangles
