// Plain arrays between Python and the core.
#pragma once
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "assembly/array_view.h"
#include "bindings/module.h"

namespace nanobind::detail {

// Views of the core (assembly/array_view.h) of arrays of Python: hold for the length of the call.
template <typename T, int... Shape>
struct type_caster<hp::ArrayView<T, Shape...>> {
  using View = hp::ArrayView<T, Shape...>;
  using Array = ndarray<const T, c_contig, device::cpu, shape<Shape...>>;
  NB_TYPE_CASTER(View, make_caster<Array>::Name)

  bool from_python(handle src, uint32_t flags, cleanup_list* cleanup) noexcept {
    if (!array_.from_python(src, flags & ~uint32_t(cast_flags::accepts_none), cleanup))
      return false;
    size_t lengths[sizeof...(Shape)];
    for (size_t i = 0; i < sizeof...(Shape); i++) lengths[i] = array_.value.shape(i);
    value = View(array_.value.data(), lengths);
    return true;
  }

 private:
  make_caster<Array> array_;
};

}  // namespace nanobind::detail

namespace hp {

using Out = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Indices = nb::ndarray<int32_t, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

inline auto array(std::vector<size_t> shape, const std::vector<double>& values) {
  double* data = new double[values.size() + 1];
  std::copy(values.begin(), values.end(), data);  // memcpy may not be given the null of none
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  return nb::ndarray<nb::numpy, double>(data, shape.size(), shape.data(), owner);
}

inline auto array(const std::vector<double>& v) { return array({v.size()}, v); }

inline auto array(const std::vector<int>& values) {
  int32_t* data = new int32_t[values.size() + 1];
  std::copy(values.begin(), values.end(), data);
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<int32_t*>(p); });
  const size_t shape[] = {values.size()};
  return nb::ndarray<nb::numpy, int32_t>(data, 1, shape, owner);
}

inline void push(std::vector<double>& out, Vec3 v) { out.insert(out.end(), {v.x, v.y, v.z}); }

}  // namespace hp
