// Arrays that somebody else owns, C-contiguous: how numbers come in, from Python or from a file.
//
// ArrayView<T, -1, 3> has any number of rows of three. What makes a view guarantees its fixed sizes;
// functions that take views check the others.
#pragma once
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "geometry/convex.h"
#include "math/vec.h"

namespace hp {

template <typename T, int... Shape>
class ArrayView {
 public:
  static constexpr size_t kDims = sizeof...(Shape);
  static constexpr int kShape[] = {Shape...};  // -1: any length

  ArrayView() = default;
  ArrayView(const T* data, const size_t (&shape)[kDims]) : data_(data) {
    for (size_t i = 0; i < kDims; i++) shape_[i] = shape[i];
  }
  const T* data() const { return data_; }
  size_t shape(size_t i) const { return shape_[i]; }
  size_t size() const {
    size_t n = 1;
    for (size_t s : shape_) n *= s;
    return n;
  }

 private:
  const T* data_ = nullptr;
  size_t shape_[kDims] = {};
};

using Doubles = ArrayView<double, -1>;
using Ints = ArrayView<int, -1>;
using Rows2 = ArrayView<double, -1, 2>;
using Rows3 = ArrayView<double, -1, 3>;
using Rows4 = ArrayView<double, -1, 4>;
using Faces = ArrayView<int, -1, 3>;
using Square = ArrayView<double, -1, -1>;
using Cube = ArrayView<double, -1, -1, -1>;

inline std::vector<Vec3> vectors(const Rows3& a) {
  std::vector<Vec3> out(a.shape(0));
  for (size_t i = 0; i < out.size(); i++) out[i] = load3(a.data() + 3 * i);
  return out;
}

inline void need(bool ok, const char* what) {
  if (!ok) throw std::invalid_argument(what);
}

inline std::vector<Quat> quats(const Rows4& a) {
  std::vector<Quat> out(a.shape(0));
  for (size_t i = 0; i < out.size(); i++) {
    out[i] = load4(a.data() + 4 * i);
    const Quat q = out[i];
    need(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z > 0.25, "a quaternion of no length");
  }
  return out;
}

template <typename T, typename A>
std::vector<T> list(const A& a) {
  return {a.data(), a.data() + a.shape(0)};
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
