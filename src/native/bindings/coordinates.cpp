// Poses as axis-angle vectors, and as quaternions in the model's coordinates. Releases the GIL.
#include <memory>

#include "bindings/arrays.h"
#include "math/vec.h"

using namespace hp;

namespace {

using Rotations = f64<nb::shape<-1, -1, 3>>;

void check(Ints at, size_t joints, size_t coordinates) {
  need(at.shape(0) == joints, "coordinates: one place per joint");
  for (size_t j = 0; j < joints; j++)
    need(at.data()[j] >= 0 && (size_t)at.data()[j] + 4 <= coordinates,
         "coordinates: no such place");
}

// Quaternions of rotations (T, joints, 3) into coordinates (T, n), each at its place.
void put_rotations(Rotations rotations, Ints at, Out out) {
  const size_t frames = rotations.shape(0), joints = rotations.shape(1), n = out.shape(1);
  need(out.shape(0) == frames, "put_rotations: another number of frames");
  check(at, joints, n);
  const double* v = rotations.data();
  const int* place = at.data();
  double* q = out.data();
  nb::gil_scoped_release release;
  for (size_t t = 0; t < frames; t++, q += n)
    for (size_t j = 0; j < joints; j++, v += 3) store4(q + place[j], exp_quat(load3(v)));
}

// The reverse: rotations (T, joints, 3), by the shortest arc, of coordinates (T, n).
auto rotations_of(Square coordinates, Ints at) {
  const size_t frames = coordinates.shape(0), n = coordinates.shape(1), joints = at.shape(0);
  check(at, joints, n);
  std::unique_ptr<double[]> values(new double[frames * joints * 3 + 1]);
  {
    const double* q = coordinates.data();
    double* v = values.get();
    nb::gil_scoped_release release;
    for (size_t t = 0; t < frames; t++, q += n)
      for (size_t j = 0; j < joints; j++, v += 3) store3(v, log_quat(load4(q + at.data()[j])));
  }
  nb::capsule owner(values.get(), [](void* p) noexcept { delete[] static_cast<double*>(p); });
  return nb::ndarray<nb::numpy, double>(values.release(), {frames, joints, 3}, owner);
}

}  // namespace

void bind_coordinates(nb::module_& m) {
  using namespace nb::literals;
  m.def("put_rotations", &put_rotations, "rotations"_a, "at"_a, "out"_a);
  m.def("rotations_of", &rotations_of, "coordinates"_a, "at"_a);
}
