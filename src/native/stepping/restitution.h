// Restitution: a contact that arrived fast enough rebounds with e times its speed (Newton's law).
//
// The rebound starts where the substep does, above the surface, and before gravity has acted: the
// speed demanded is that of the parabola which meets the surface and leaves it e times as fast.
// With v_n the normal velocity at arrival, g_n its change by gravity in the substep and d the gap
// to go,
//
//   height = 2 g_n d / h,   met = v_n - g_n/2,   back^2 = e^2 (met^2 + height) - height
//
// and the contact demands  v_n' = back - g_n/2  in a second solve (Contact::bounce [m/s]).
//
// Newton's law says nothing of friction: where several points, or an eccentric one, rebound with
// friction, it can gain energy. With u and u' the relative velocities before and after, the impulses
// of an island do the work
//
//   W = sum p . (u + u')/2
//
// and where W > 0 all `back` of the island are cut by the same share, the largest for which W <= 0
// (bisection). With none W <= 0 by Coulomb's law.
#pragma once
#include <functional>

#include "stepping/data.h"

namespace hp {

class Rebounds {
 public:
  // Sets the demands of contacts that rebound in a step and opens their islands; false if none does.
  bool demand(const System& system, Data& data);
  // After `solve` has met them: cuts them in islands that gained energy, solving those again.
  void bound_energy(const System& system, Data& data, const std::function<void()>& solve);

 private:
  bool find_gains(const System& system, Data& data);
  void scale(const System& system, Data& data, const std::vector<double>& share);

  std::vector<double> before_;        // velocities that bodies arrive with
  std::vector<double> share_;         // per root body: of the demands of its island
  std::vector<double> work_, moved_;  // per root body of an island [J]
  std::vector<Twist> free_, arrived_, spun_;
};

}  // namespace hp
