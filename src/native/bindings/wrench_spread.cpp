// Wrenches spread over places that carry (support/wrench_spread.h), for support/wrench_qp.py.
#include "support/wrench_spread.h"

#include <vector>

#include "bindings/arrays.h"

using namespace hp;

namespace {

nb::ndarray<nb::numpy, double> spread_wrenches(f64<nb::shape<-1, 6>> wrench, Ints first, Rows3 arm,
                                               Rows3 normal, Doubles friction, Doubles ready,
                                               Doubles penalties, double moments, double shear,
                                               double tolerance, int steps, int searches) {
  const size_t frames = wrench.shape(0), n = arm.shape(0);
  need(first.shape(0) == frames + 1, "first: expected one more than frames");
  need(normal.shape(0) == n && friction.shape(0) == n && ready.shape(0) == n,
       "normal, friction and ready: expected one of every place");
  need(first.data()[0] == 0 && (size_t)first.data()[frames] == n, "first: expected 0 to n");
  for (size_t f = 0; f < frames; f++)
    need(first.data()[f] <= first.data()[f + 1], "first: expected ascending places");
  std::vector<double> out(3 * n);
  const SpreadOptions options{list<double>(penalties), moments, shear, tolerance, steps, searches};
  {
    nb::gil_scoped_release release;
    std::vector<CarryingPlace> places;
    std::vector<Vec3> force;
    for (size_t f = 0; f < frames; f++) {
      const size_t low = first.data()[f], high = first.data()[f + 1];
      places.clear();
      for (size_t i = low; i < high; i++)
        places.push_back({load3(arm.data() + 3 * i), load3(normal.data() + 3 * i),
                          friction.data()[i], ready.data()[i] * ready.data()[i]});
      spread_wrench(wrench.data() + 6 * f, places, options, force);
      for (size_t i = low; i < high; i++) store3(out.data() + 3 * i, force[i - low]);
    }
  }
  return array({n, 3}, out);
}

}  // namespace

void bind_wrench_spread(nb::module_& m) {
  m.def("spread_wrenches", &spread_wrenches, nb::arg("wrench"), nb::arg("first"), nb::arg("arm"),
        nb::arg("normal"), nb::arg("friction"), nb::arg("ready"), nb::kw_only(),
        nb::arg("penalties"), nb::arg("moments"), nb::arg("shear"), nb::arg("tolerance"),
        nb::arg("steps"), nb::arg("searches"),
        "Forces (n, 3) at places first[f] to first[f + 1] of every frame that come closest to its "
        "wrench (T, 6).");
}
