// Points against triangle meshes: `TriangleTree` for Python (see triangle_tree.h). Releases the
// GIL; any number of threads gives the same bits, as every point is answered on its own.
#include "bindings/module.h"
#include "geometry/triangle_tree.h"

#include <atomic>
#include <cstdint>
#include <thread>
#include <utility>

namespace {

using triangles::Tree;
using triangles::Vec;

constexpr size_t kBlock = 256;    // points a thread takes at a time

// Calls work(begin, end) over [0, n) in blocks.
template <typename Work>
void in_blocks(size_t n, int threads, const Work& work) {
  std::atomic<size_t> next{0};
  auto run = [&] {
    for (size_t i; (i = next.fetch_add(kBlock)) < n;) work(i, std::min(n, i + kBlock));
  };
  const size_t helpers = std::min<size_t>(std::max(threads, 1) - 1, n / kBlock);
  std::vector<std::thread> pool;
  for (size_t k = 0; k < helpers; ++k) pool.emplace_back(run);
  run();
  for (std::thread& t : pool) t.join();
}

using Points = f64<nb::shape<-1, 3>>;

template <typename T, size_t Dim>
nb::ndarray<nb::numpy, T> own(std::vector<T>* data, const size_t (&shape)[Dim]) {
  nb::capsule owner(data, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::ndarray<nb::numpy, T>(data->data(), Dim, shape, owner);
}

// One answer of type T per point, from answer(point, index).
template <typename T, typename Answer>
nb::ndarray<nb::numpy, T> per_point(Points points, int threads, const Answer& answer) {
  const size_t n = points.shape(0);
  const double* p = points.data();
  auto* out = new std::vector<T>(n);
  {
    nb::gil_scoped_release release;
    in_blocks(n, threads, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i)
        (*out)[i] = answer(Vec{p[3 * i], p[3 * i + 1], p[3 * i + 2]}, i);
    });
  }
  return own(out, {n});
}

nb::tuple distance(const Tree& tree, Points points, int threads) {
  const size_t n = points.shape(0);
  const double* p = points.data();
  auto* distance = new std::vector<double>(n);
  auto* face = new std::vector<int>(n);
  auto* closest = new std::vector<double>(3 * n);
  {
    nb::gil_scoped_release release;
    in_blocks(n, threads, [&](size_t begin, size_t end) {
      int guess = -1;
      for (size_t i = begin; i < end; ++i) {
        Vec q{};
        guess = tree.closest({p[3 * i], p[3 * i + 1], p[3 * i + 2]}, guess, q, (*distance)[i]);
        (*face)[i] = tree.face(guess);
        (*closest)[3 * i] = q.x;
        (*closest)[3 * i + 1] = q.y;
        (*closest)[3 * i + 2] = q.z;
      }
    });
  }
  return nb::make_tuple(own(distance, {n}), own(face, {n}), own(closest, {n, size_t{3}}));
}

// Bits of a number, two zeros after each.
uint64_t spread(uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

// Points by threshold, then along a curve through space: neighbours stand together.
std::vector<int> in_space(const double* p, const double* threshold, size_t n) {
  double lo[3] = {p[0], p[1], p[2]}, hi[3] = {p[0], p[1], p[2]};
  for (size_t i = 0; i < 3 * n; ++i) {
    lo[i % 3] = std::min(lo[i % 3], p[i]);
    hi[i % 3] = std::max(hi[i % 3], p[i]);
  }
  const double size = std::max({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2], 1e-300});
  std::vector<std::pair<uint64_t, int>> key(n);
  for (size_t i = 0; i < n; ++i) {
    uint64_t code = 0;
    for (int k = 0; k < 3; ++k)
      code |= spread(static_cast<uint64_t>((p[3 * i + k] - lo[k]) / size * 4095.0)) << k;
    key[i] = {code, static_cast<int>(i)};
  }
  std::sort(key.begin(), key.end(), [&](const auto& a, const auto& b) {
    const double s = threshold[a.second], t = threshold[b.second];
    return s != t ? s < t : a < b;
  });
  std::vector<int> order(n);
  for (size_t i = 0; i < n; ++i) order[i] = key[i].second;
  return order;
}

// Whether the winding number is over a threshold, for each point its own: whole numbers apart.
nb::ndarray<nb::numpy, uint8_t> exceeds(const Tree& tree, Points points, const double* threshold,
                                        int threads) {
  const size_t n = points.shape(0);
  const double* p = points.data();
  auto* out = new std::vector<uint8_t>(n);
  if (n > 0) {
    nb::gil_scoped_release release;
    std::vector<int> order = in_space(p, threshold, n);
    auto point = [p](int i) { return Vec{p[3 * i], p[3 * i + 1], p[3 * i + 2]}; };
    auto tell = [out](int i, bool yes) { (*out)[i] = yes; };
    in_blocks(n, threads, [&](size_t begin, size_t end) {
      for (size_t i = begin, j; i < end; i = j) {
        const double t = threshold[order[i]];
        for (j = i + 1; j < end && threshold[order[j]] == t;) ++j;
        tree.exceeds_all(point, &order[i], static_cast<int>(j - i), t, tell);
      }
    });
  }
  return own(out, {n});
}

void need_winding(const Tree& tree) {
  if (!tree.has_winding()) throw std::invalid_argument("built without winding=True");
}

}  // namespace

void bind_winding(nb::module_& m) {
  nb::class_<Tree>(m, "TriangleTree",
                   "Tree over a triangle soup: vertices (V, 3) [m], faces (F, 3). "
                   "winding: also keep what `winding` and `exceeds` need.")
      .def(
          "__init__",
          [](Tree* self, Points vertices, i32<nb::shape<-1, 3>> faces, bool winding) {
            nb::gil_scoped_release release;
            new (self)
                Tree(vertices.data(), vertices.shape(0), faces.data(), faces.shape(0), winding);
          },
          nb::arg("vertices"), nb::arg("faces"), nb::arg("winding") = false)
      .def("distance", &distance, nb::arg("points"), nb::arg("threads") = 1,
           "Distances (n,) [m], nearest faces (n,) and closest points (n, 3) [m].")
      .def(
          "crossings",
          [](const Tree& self, Points points, int threads) {
            return per_point<int>(points, threads,
                                  [&](Vec q, size_t) { return self.crossings(q); });
          },
          nb::arg("points"), nb::arg("threads") = 1,
          "Signed crossings of the rays upward (n,): the winding number of closed triangles.")
      .def(
          "winding",
          [](const Tree& self, Points points, double tolerance, int threads) {
            need_winding(self);
            return per_point<double>(points, threads, [&](Vec q, size_t) {
              return self.winding_within(q, tolerance);
            });
          },
          nb::arg("points"), nb::arg("tolerance") = 1e-6, nb::arg("threads") = 1,
          "Generalised winding numbers (n,), off by at most `tolerance`; 0: the full sum.")
      .def(
          "exceeds",
          [](const Tree& self, Points points, f64<nb::shape<-1>> threshold, int threads) {
            need_winding(self);
            if (threshold.shape(0) != points.shape(0))
              throw std::invalid_argument("one threshold per point is needed");
            return exceeds(self, points, threshold.data(), threads);
          },
          nb::arg("points"), nb::arg("threshold"), nb::arg("threads") = 1,
          "1 where the winding number is over threshold (n,), else 0: as the full sum would say.");
}
