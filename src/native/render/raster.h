// Software z-buffer: types and exact coverage. Projection and clipping are in projection.h, lights
// and shadows in shading.h, the tiles of a picture in tiles.h, whole pictures in picture.h.
//
// Camera frame: x right, y down, z forward [m]. Coverage is decided in integers (steps of
// 1/256 sample), so that neighbouring triangles leave no crack and the result does not depend on the
// order of evaluation.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tuning.h"

namespace raster {

struct Vec {
  double x = 0, y = 0, z = 0;
};
inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline Vec operator*(Vec a, Vec b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(Vec a, Vec b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec unit(Vec a) {
  const double n = std::sqrt(dot(a, a));
  return n > 0 ? (1.0 / n) * a : Vec{0, 0, 1};
}
inline Vec mix(Vec a, Vec b, double t) { return (1.0 - t) * a + t * b; }
inline double clamp01(double t) { return t < 0 ? 0 : t > 1 ? 1 : t; }

// How one mesh looks. Colours are linear light, 0 to 1.
struct Style {
  Vec color, checker;         // checker: second colour of a chequered surface
  double alpha;               // < 1: drawn as one translucent layer
  double rim;                 // opaque: light added at grazing angles; translucent: alpha added
  double checker_size;        // [m], 0: plain
  double bias;                // a translucent layer shows only where it is nearer by this [m]
  double fade_from, fade_to;  // dissolves into the background at these distances from `focus`
  double crease;              // cosine of the angle beyond which an edge stays sharp
  int cull;                   // 0 none, 1 drops back faces, 2 drops front faces
  bool casts, receives;       // shadows
};

struct Camera {
  Vec right, down, forward, position;
  double fx, fy, cx, cy, near;  // [px], [m]
  int width, height, samples;   // samples x samples per pixel
  Vec to_camera(Vec p) const {
    const Vec d = p - position;
    return {dot(d, right), dot(d, down), dot(d, forward)};
  }
  Vec direction(double u, double v) const { return {(u - cx) / fx, (v - cy) / fy, 1.0}; }
  Vec to_world(Vec p) const { return position + p.x * right + p.y * down + p.z * forward; }
};

struct Meshes {
  std::vector<Vec> world, view;  // vertices
  std::vector<std::array<int, 3>> faces;
  std::vector<int> mesh_of_face;
  std::vector<std::array<Vec, 3>> normals;  // per corner, world
  std::vector<Style> styles;
};

// A triangle on a sample grid. The value a x + b y + c (inverse depth, or height in a shadow
// map) is linear over the grid; lo and hi bound it, so that slivers cannot run away.
struct Tri {
  std::int64_t x[3], y[3];  // steps; counter-clockwise in grid orientation
  double a, b, c, lo, hi;
  int face, mesh;
  double value(int i, int j) const {
    const double v = a * (i + 0.5) + b * (j + 0.5) + c;
    return v < lo ? lo : v > hi ? hi : v;
  }
};

// Sets the corners (grid coordinates); false when the triangle has no area.
inline bool set_corners(Tri& t, const double gx[3], const double gy[3]) {
  const double steps = hp::tuning::render::kStepsPerSample;
  for (int k = 0; k < 3; ++k) {
    t.x[k] = std::llround(gx[k] * steps);
    t.y[k] = std::llround(gy[k] * steps);
  }
  const std::int64_t area =
      (t.x[1] - t.x[0]) * (t.y[2] - t.y[0]) - (t.y[1] - t.y[0]) * (t.x[2] - t.x[0]);
  if (area == 0) return false;
  if (area < 0) {
    std::swap(t.x[1], t.x[2]);
    std::swap(t.y[1], t.y[2]);
  }
  return true;
}

struct Box {
  int x0, y0, x1, y1;  // half open, in samples
  bool empty() const { return x0 >= x1 || y0 >= y1; }
};

// The smallest sample i whose centre is at or beyond a coordinate in steps.
inline int first_centre(std::int64_t fixed) {
  const std::int64_t steps = hp::tuning::render::kStepsPerSample, n = fixed + steps / 2 - 1;
  return static_cast<int>(n >= 0 ? n / steps : -((-n + steps - 1) / steps));
}

inline Box bounds(const Tri& t, const Box& limit) {
  const auto [xa, xb] = std::minmax({t.x[0], t.x[1], t.x[2]});
  const auto [ya, yb] = std::minmax({t.y[0], t.y[1], t.y[2]});
  return {std::max(limit.x0, first_centre(xa)), std::max(limit.y0, first_centre(ya)),
          std::min(limit.x1, first_centre(xb + 1)), std::min(limit.y1, first_centre(yb + 1))};
}

// Calls put(i, j, value) for every sample of `limit` that the triangle covers, edges included.
template <class Put>
void fill(const Tri& t, const Box& limit, Put put) {
  const Box box = bounds(t, limit);
  if (box.empty()) return;
  const std::int64_t steps = hp::tuning::render::kStepsPerSample;
  std::int64_t row[3], dx[3], dy[3];
  for (int k = 0; k < 3; ++k) {
    const int n = (k + 1) % 3;
    const std::int64_t ex = t.x[n] - t.x[k], ey = t.y[n] - t.y[k];
    row[k] =
        ex * (steps * box.y0 + steps / 2 - t.y[k]) - ey * (steps * box.x0 + steps / 2 - t.x[k]);
    dx[k] = -steps * ey;
    dy[k] = steps * ex;
  }
  for (int j = box.y0; j < box.y1; ++j) {
    std::int64_t e0 = row[0], e1 = row[1], e2 = row[2];
    for (int i = box.x0; i < box.x1; ++i) {
      if ((e0 | e1 | e2) >= 0) put(i, j, t.value(i, j));
      e0 += dx[0];
      e1 += dx[1];
      e2 += dx[2];
    }
    for (int k = 0; k < 3; ++k) row[k] += dy[k];
  }
}

}  // namespace raster
