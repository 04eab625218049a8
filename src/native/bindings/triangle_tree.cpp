// Points against triangle meshes: `TriangleTree` for Python (geometry/point_queries.h). Releases the GIL.
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "bindings/module.h"
#include "geometry/point_queries.h"

namespace {

using triangles::Tree;
using PointArray = f64<nb::shape<-1, 3>>;

template <typename T, size_t Dim>
nb::ndarray<nb::numpy, T> own(std::vector<T>* data, const size_t (&shape)[Dim]) {
  nb::capsule owner(data, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::ndarray<nb::numpy, T>(data->data(), Dim, shape, owner);
}

nb::tuple distance(const Tree& tree, PointArray points, int threads) {
  const size_t n = points.shape(0);
  auto* distance = new std::vector<double>(n);
  auto* face = new std::vector<int>(n);
  auto* closest = new std::vector<double>(3 * n);
  {
    nb::gil_scoped_release release;
    triangles::closest_points(tree, points.data(), n, threads, distance->data(), face->data(),
                              closest->data());
  }
  return nb::make_tuple(own(distance, {n}), own(face, {n}), own(closest, {n, size_t{3}}));
}

void need_winding(const Tree& tree) {
  if (!tree.has_winding()) throw std::invalid_argument("built without winding=True");
}

}  // namespace

void bind_triangle_tree(nb::module_& m) {
  nb::class_<Tree>(m, "TriangleTree",
                   "Tree over a triangle soup: vertices (V, 3) [m], faces (F, 3). "
                   "winding: also keep what `winding` and `exceeds` need.")
      .def(
          "__init__",
          [](Tree* self, PointArray vertices, i32<nb::shape<-1, 3>> faces, bool winding) {
            nb::gil_scoped_release release;
            new (self)
                Tree(vertices.data(), vertices.shape(0), faces.data(), faces.shape(0), winding);
          },
          nb::arg("vertices"), nb::arg("faces"), nb::arg("winding") = false)
      .def("distance", &distance, nb::arg("points"), nb::arg("threads") = 1,
           "Distances (n,) [m], nearest faces (n,) and closest points (n, 3) [m].")
      .def(
          "crossings",
          [](const Tree& self, PointArray points, int threads) {
            const size_t n = points.shape(0);
            auto* out = new std::vector<int>(n);
            {
              nb::gil_scoped_release release;
              triangles::crossings(self, points.data(), n, threads, out->data());
            }
            return own(out, {n});
          },
          nb::arg("points"), nb::arg("threads") = 1,
          "Signed crossings of the rays upward (n,): the winding number of closed triangles.")
      .def(
          "winding",
          [](const Tree& self, PointArray points, double tolerance, int threads) {
            need_winding(self);
            const size_t n = points.shape(0);
            auto* out = new std::vector<double>(n);
            {
              nb::gil_scoped_release release;
              triangles::winding_numbers(self, points.data(), n, tolerance, threads, out->data());
            }
            return own(out, {n});
          },
          nb::arg("points"), nb::arg("tolerance") = 1e-6, nb::arg("threads") = 1,
          "Generalised winding numbers (n,), off by at most `tolerance`; 0: the full sum.")
      .def(
          "exceeds",
          [](const Tree& self, PointArray points, f64<nb::shape<-1>> threshold, int threads) {
            need_winding(self);
            const size_t n = points.shape(0);
            if (threshold.shape(0) != n)
              throw std::invalid_argument("one threshold per point is needed");
            auto* out = new std::vector<uint8_t>(n);
            {
              nb::gil_scoped_release release;
              triangles::exceeds(self, points.data(), n, threshold.data(), threads, out->data());
            }
            return own(out, {n});
          },
          nb::arg("points"), nb::arg("threshold"), nb::arg("threads") = 1,
          "1 where the winding number is over threshold (n,), else 0: as the full sum would say.");
}
