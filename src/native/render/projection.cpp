#include "render/projection.h"

#include "tuning.h"

namespace raster {

namespace {

// Clips a convex polygon against dot(plane, p) >= offset.
void clip(std::vector<Vec>& poly, Vec plane, double offset, std::vector<Vec>& scratch) {
  scratch.clear();
  for (std::size_t k = 0; k < poly.size(); ++k) {
    const Vec p = poly[k], q = poly[(k + 1) % poly.size()];
    const double dp = dot(plane, p) - offset, dq = dot(plane, q) - offset;
    if (dp >= 0) scratch.push_back(p);
    if ((dp >= 0) != (dq >= 0)) scratch.push_back(mix(p, q, dp / (dp - dq)));
  }
  poly.swap(scratch);
}

}  // namespace

std::vector<Tri> project(const Meshes& m, const Camera& cam) {
  std::vector<Tri> out;
  out.reserve(m.faces.size());
  std::vector<Vec> poly, scratch;
  const double gx = hp::tuning::render::kGuardBand * cam.width / cam.fx,
               gy = hp::tuning::render::kGuardBand * cam.height / cam.fy;
  const Vec planes[5] = {{0, 0, 1}, {1, 0, gx}, {-1, 0, gx}, {0, 1, gy}, {0, -1, gy}};
  for (std::size_t f = 0; f < m.faces.size(); ++f) {
    const auto& face = m.faces[f];
    const Vec p[3] = {m.view[face[0]], m.view[face[1]], m.view[face[2]]};
    const Vec n = cross(p[1] - p[0], p[2] - p[0]);
    const double height = dot(n, p[0]);  // < 0: front face
    const int cull = m.styles[m.mesh_of_face[f]].cull;
    if (height == 0 || (cull == 1 && height > 0) || (cull == 2 && height < 0)) continue;
    poly.assign(p, p + 3);
    for (int k = 0; k < 5 && poly.size() >= 3; ++k) {
      const double offset = k == 0 ? cam.near : 0.0;
      bool out_of_plane = false;
      for (const Vec& q : poly) out_of_plane = out_of_plane || dot(planes[k], q) < offset;
      if (out_of_plane) clip(poly, planes[k], offset, scratch);
    }
    if (poly.size() < 3) continue;
    const int s = cam.samples;
    Tri t;
    t.face = static_cast<int>(f);
    t.mesh = m.mesh_of_face[f];
    // 1 / depth = n . direction(u, v) / (n . p0), with u = x / samples.
    t.a = n.x / (cam.fx * s * height);
    t.b = n.y / (cam.fy * s * height);
    t.c = (n.z - n.x * cam.cx / cam.fx - n.y * cam.cy / cam.fy) / height;
    t.lo = 1e300;
    t.hi = 0;
    for (const Vec& q : poly) {
      t.lo = std::min(t.lo, 1.0 / q.z);
      t.hi = std::max(t.hi, 1.0 / q.z);
    }
    const auto px = [&](const Vec& q) { return (cam.fx * q.x / q.z + cam.cx) * s; };
    const auto py = [&](const Vec& q) { return (cam.fy * q.y / q.z + cam.cy) * s; };
    for (std::size_t k = 2; k < poly.size(); ++k) {
      const double x[3] = {px(poly[0]), px(poly[k - 1]), px(poly[k])};
      const double y[3] = {py(poly[0]), py(poly[k - 1]), py(poly[k])};
      if (set_corners(t, x, y)) out.push_back(t);
    }
  }
  return out;
}

void compute_normals(Meshes& m) {
  const std::size_t faces = m.faces.size();
  std::vector<Vec> area(faces), normal(faces);
  std::vector<int> start(m.world.size() + 1, 0);
  for (std::size_t f = 0; f < faces; ++f) {
    const auto& t = m.faces[f];
    area[f] = cross(m.world[t[1]] - m.world[t[0]], m.world[t[2]] - m.world[t[0]]);
    normal[f] = unit(area[f]);
    for (int v : t) ++start[v + 1];
  }
  for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
  std::vector<int> around(start.back()), next(start.begin(), start.end() - 1);
  for (std::size_t f = 0; f < faces; ++f)
    for (int v : m.faces[f]) around[next[v]++] = static_cast<int>(f);
  m.normals.resize(faces);
  for (std::size_t f = 0; f < faces; ++f) {
    const double crease = m.styles[m.mesh_of_face[f]].crease;
    for (int k = 0; k < 3; ++k) {
      const int v = m.faces[f][k];
      Vec sum;
      for (int e = start[v]; e < start[v + 1]; ++e)
        if (dot(normal[around[e]], normal[f]) >= crease) sum = sum + area[around[e]];
      m.normals[f][k] = dot(sum, sum) > 0 ? unit(sum) : normal[f];
    }
  }
}

}  // namespace raster
