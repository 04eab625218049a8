#include "render/shading.h"

#include "tuning.h"

namespace raster {

namespace tune = hp::tuning::render;

namespace {

// Mean of a chequerboard of +1 and -1 over a box of width w centred on x (one axis).
double checker_mean(double x, double w) {
  const auto integral = [](double t) {  // of the square wave with period 2, a triangle wave
    const double r = t - 2.0 * std::floor(0.5 * t);
    return r < 1.0 ? r : 2.0 - r;
  };
  return (integral(x + 0.5 * w) - integral(x - 0.5 * w)) / w;
}

}  // namespace

ShadowMap::ShadowMap(const Light& light, const Meshes& m) {
  w = light.towards;
  u = unit(cross(std::abs(w.z) < 0.9 ? Vec{0, 0, 1} : Vec{1, 0, 0}, w));
  v = cross(w, u);
  double box[4] = {1e300, -1e300, 1e300, -1e300};
  bool any = false;
  for (std::size_t f = 0; f < m.faces.size(); ++f) {
    if (!m.styles[m.mesh_of_face[f]].casts) continue;
    any = true;
    for (int k : m.faces[f]) {
      const double a = dot(u, m.world[k]), b = dot(v, m.world[k]);
      box[0] = std::min(box[0], a);
      box[1] = std::max(box[1], a);
      box[2] = std::min(box[2], b);
      box[3] = std::max(box[3], b);
    }
  }
  if (!any) return;
  const double extent = std::max(box[1] - box[0], box[3] - box[2]);
  texel = std::max(light.softness / (2 * tune::kShadowTaps + 1),
                   extent / (tune::kMostTexels - 4 * tune::kShadowTaps - 4));
  texel = std::max(texel, 1e-6);
  const int margin = 2 * tune::kShadowTaps + 1;
  width = static_cast<int>((box[1] - box[0]) / texel) + 2 * margin + 1;
  height = static_cast<int>((box[3] - box[2]) / texel) + 2 * margin + 1;
  u0 = box[0] - margin * texel;
  v0 = box[2] - margin * texel;
  top.assign(static_cast<std::size_t>(width) * height, -1e30f);
  for (std::size_t f = 0; f < m.faces.size(); ++f)
    if (m.styles[m.mesh_of_face[f]].casts) draw(m, m.faces[f]);
}

void ShadowMap::draw(const Meshes& m, const std::array<int, 3>& face) {
  double x[3], y[3], h[3];
  for (int k = 0; k < 3; ++k) {
    x[k] = (dot(u, m.world[face[k]]) - u0) / texel;
    y[k] = (dot(v, m.world[face[k]]) - v0) / texel;
    h[k] = dot(w, m.world[face[k]]);
  }
  Tri t{};
  if (!set_corners(t, x, y)) return;
  const double area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
  if (area == 0) return;
  t.a = ((h[1] - h[0]) * (y[2] - y[0]) - (h[2] - h[0]) * (y[1] - y[0])) / area;
  t.b = ((h[2] - h[0]) * (x[1] - x[0]) - (h[1] - h[0]) * (x[2] - x[0])) / area;
  t.c = h[0] - t.a * x[0] - t.b * y[0];
  t.lo = std::min({h[0], h[1], h[2]});
  t.hi = std::max({h[0], h[1], h[2]});
  fill(t, {0, 0, width, height}, [&](int i, int j, double value) {
    float& cell = top[static_cast<std::size_t>(j) * width + i];
    cell = std::max(cell, static_cast<float>(value));
  });
}

double ShadowMap::lit(Vec p, Vec normal) const {
  if (top.empty()) return 1.0;
  // Beside a wall the box would reach into it: step out by its half width.
  p = p + (1.5 + (1.0 - std::abs(dot(w, normal))) * tune::kShadowTaps) * texel * normal;
  const double x = (dot(u, p) - u0) / texel - 0.5, y = (dot(v, p) - v0) / texel - 0.5;
  const double h = dot(w, p) + 1e-4;
  const double nw = std::max(dot(w, normal), 0.25);
  const double sx = -dot(u, normal) / nw * texel, sy = -dot(v, normal) / nw * texel;
  const double bx = std::floor(x), by = std::floor(y);
  if (bx < -tune::kShadowTaps || by < -tune::kShadowTaps || bx > width + tune::kShadowTaps ||
      by > height + tune::kShadowTaps)
    return 1.0;
  const double fx = x - bx, fy = y - by;
  const int ix = static_cast<int>(bx), iy = static_cast<int>(by);
  double open = 0;
  for (int j = -tune::kShadowTaps; j <= tune::kShadowTaps + 1; ++j) {
    const double wy = j == -tune::kShadowTaps ? 1 - fy : j == tune::kShadowTaps + 1 ? fy : 1.0;
    const int row = iy + j;
    double line = 0;
    for (int i = -tune::kShadowTaps; i <= tune::kShadowTaps + 1; ++i) {
      const double wx = i == -tune::kShadowTaps ? 1 - fx : i == tune::kShadowTaps + 1 ? fx : 1.0;
      const int col = ix + i;
      const bool inside = row >= 0 && col >= 0 && row < height && col < width;
      const double plane = h + sx * (i - fx) + sy * (j - fy);
      if (!inside || top[static_cast<std::size_t>(row) * width + col] <= plane) line += wx;
    }
    open += wy * line;
  }
  constexpr double total = (2 * tune::kShadowTaps + 1) * (2 * tune::kShadowTaps + 1);
  return open / total;
}

Shader::Shader(const Meshes& m, const Camera& cam, const Look& look)
    : m_(m), cam_(cam), look_(look) {
  for (const Light& light : look.lights) shadows_.emplace_back(light, m);
}

// Coordinates of the point where the ray through (u, v) meets the face's plane: a + s e1 + t e2.
void Shader::meet(const Plane& f, double u, double v, double& s, double& t) const {
  const Vec d = cam_.direction(u, v);
  const double along = dot(f.n, d);
  const Vec p = std::abs(along) > 0 ? (f.height / along) * d - f.a : Vec{};
  s = dot(cross(p, f.e2), f.n) / f.nn;
  t = dot(cross(f.e1, p), f.n) / f.nn;
}

// A chequered surface at the point p that (u, v) shows, its edges blurred over one pixel.
Vec Shader::board(const Style& style, const Plane& f, double u, double v, Vec p) const {
  double s1, t1, s2, t2;
  meet(f, u + 1, v, s1, t1);
  meet(f, u, v + 1, s2, t2);
  const Vec px = cam_.to_world(f.a + s1 * f.e1 + t1 * f.e2) - p;
  const Vec py = cam_.to_world(f.a + s2 * f.e1 + t2 * f.e2) - p;
  const double k = 1.0 / style.checker_size;
  const double wx = std::max(k * (std::abs(px.x) + std::abs(py.x)), 1e-6);
  const double wy = std::max(k * (std::abs(px.y) + std::abs(py.y)), 1e-6);
  const double board = checker_mean(k * p.x, wx) * checker_mean(k * p.y, wy);
  return mix(style.color, style.checker, 0.5 - 0.5 * board);
}

Vec Shader::light_at(const Style& style, Vec p, Vec normal) const {
  Vec light = mix(look_.ground, look_.sky, 0.5 + 0.5 * normal.z);
  for (std::size_t k = 0; k < shadows_.size(); ++k) {
    const Light& l = look_.lights[k];
    double share = l.strength * (dot(normal, l.towards) + l.wrap) / (1 + l.wrap);
    if (share <= 0) continue;
    if (style.receives) share *= shadows_[k].lit(p, normal);
    light = light + Vec{share, share, share};
  }
  return light;
}

Vec Shader::shade(int f, double u, double v, double& alpha) const {
  const Style& style = m_.styles[m_.mesh_of_face[f]];
  const auto& face = m_.faces[f];
  const Vec a = m_.view[face[0]], e1 = m_.view[face[1]] - a, e2 = m_.view[face[2]] - a;
  const Vec n = cross(e1, e2);
  const Plane plane{a, e1, e2, n, dot(n, n), dot(n, a)};
  double s, t;
  meet(plane, u, v, s, t);
  // A point taken beside a sliver's edge must not leave the triangle.
  s = clamp01(s);
  t = std::min(clamp01(t), 1.0 - s);
  const Vec p = cam_.to_world(a + s * e1 + t * e2);
  const auto& c = m_.normals[f];
  Vec normal = unit((1 - s - t) * c[0] + s * c[1] + t * c[2]);
  if (plane.height > 0) normal = -1.0 * normal;  // seen from behind
  const Vec eye = unit(cam_.position - p);

  const Vec albedo = style.checker_size > 0 ? board(style, plane, u, v, p) : style.color;
  Vec color = albedo * light_at(style, p, normal);
  const double graze = 1.0 - clamp01(std::abs(dot(normal, eye)));
  alpha = style.alpha;
  if (style.alpha < 1.0) {
    alpha = clamp01(alpha + style.rim * graze * graze);
  } else {
    const double rim = style.rim * graze * graze * graze;
    color = color + rim * Vec{1, 1, 1};
  }
  if (style.fade_to > style.fade_from) {
    const Vec d = p - look_.focus;
    const double r = std::sqrt(dot(d, d));
    const double x = clamp01((r - style.fade_from) / (style.fade_to - style.fade_from));
    const double soft = x * x * (3 - 2 * x);
    if (style.alpha < 1.0)
      alpha *= 1 - soft;
    else
      color = mix(color, background(v), soft);
  }
  return color;
}

}  // namespace raster
