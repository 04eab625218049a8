// Plain arrays between Python and the core.
#pragma once
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "geometry/convex.h"
#include "bindings/module.h"

namespace hp {

using Doubles = f64<nb::ndim<1>>;
using Ints = i32<nb::ndim<1>>;
using Rows2 = f64<nb::shape<-1, 2>>;
using Rows3 = f64<nb::shape<-1, 3>>;
using Rows4 = f64<nb::shape<-1, 4>>;
using Faces = i32<nb::shape<-1, 3>>;
using Square = f64<nb::shape<-1, -1>>;
using Out = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Indices = nb::ndarray<int32_t, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

inline std::vector<Vec3> vectors(const Rows3& a) {
  std::vector<Vec3> out(a.shape(0));
  for (size_t i = 0; i < out.size(); i++) out[i] = load3(a.data() + 3 * i);
  return out;
}

inline std::vector<Quat> quats(const Rows4& a) {
  std::vector<Quat> out(a.shape(0));
  for (size_t i = 0; i < out.size(); i++) out[i] = load4(a.data() + 4 * i);
  return out;
}

template <typename T, typename A>
std::vector<T> list(const A& a) {
  return {a.data(), a.data() + a.shape(0)};
}

inline auto array(std::vector<size_t> shape, const std::vector<double>& values) {
  double* data = new double[values.size() + 1];
  std::copy(values.begin(), values.end(), data);  // memcpy may not be given the null of none
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  return nb::ndarray<nb::numpy, double>(data, shape.size(), shape.data(), owner);
}

inline auto array(const std::vector<double>& v) { return array({v.size()}, v); }

inline void push(std::vector<double>& out, Vec3 v) { out.insert(out.end(), {v.x, v.y, v.z}); }

inline void need(bool ok, const char* what) {
  if (!ok) throw std::invalid_argument(what);
}

// `rim` is the axis of the disc times its radius; zero: none.
inline Convex convex(const Rows3& vertices, double radius, const Doubles& rim,
                     std::vector<Vec3> normals = {}) {
  need(vertices.shape(0) > 0, "a shape needs at least one vertex");
  need(rim.shape(0) == 3, "rim: expected (3,)");
  Convex c;
  c.vertices = vectors(vertices);
  c.normals = std::move(normals);
  c.radius = radius;
  Vec3 r = load3(rim.data());
  c.rim = norm(r);
  if (c.rim > 0) c.axis = (1 / c.rim) * r;
  c.finish();
  return c;
}

}  // namespace hp
