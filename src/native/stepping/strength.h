// Strength: what a drive exerts, and limits of it (docs/physics.md, "What the drive exerts").
//
// A substep solves M^ (v - v*) = J^T p with M^ = s (M + X). Of what changes the deviation e = v -
// v_ref of a body of inertia M, the contacts' impulse J^T p is one part; the rest is the drive's [N
// s, N m s]:
//
//   h tau = M (e - e_before) - M^ (v - v*)        (+ h load of held objects, held_load.h)
//
// Self-contact moves the limbs that touch alone (self_response.h): what the other joints hold against it,
// step.braced, is no force of theirs on the world and is added.
// The weight that rests on layers (layer_load.h) is in v* and none of it. It is zero in free motion,
// and balances the contacts in a static hold. With limits tau_max the drive
//   1. pulls the deviation back by at most D with M^_jj |D_j| <= h tau_max,j (limit());
//   2. and with |(M^ D)_j| <= h tau_max,j, coupling included (limit());
//   3. resists contacts less where a joint exerts more: M^ - M becomes theta (M^ - M) theta with
//      theta_j <= 1, and the substep is solved again, round by round (give_in()). In a step that is made
//      in pieces what was exerted in those before counts (keep()).
// Joints that are too weak for rule 2 in free motion give way like dry friction (held_load.h).
// src/halfphysics/reference/strength.py has the rules in plain numpy.
#pragma once
#include <vector>

#include "stepping/baselines/internal_forces.h"
#include "stepping/data.h"
#include "stepping/held_load.h"

namespace hp {

class StrengthLimits {
 public:
  StrengthLimits(const HeldLoad& load, const InternalForces& internal)
      : load_(load), internal_(internal) {}
  void finish(const Model& m);
  // Rules 1 and 2, on step.v_free. Where nothing is limited v* stays as it is, bit for bit.
  void limit(const System& system, Data& data, double h);
  // Contacts come: step.v_free is v*.
  void begin(const System& system, const Step& step);
  // Rule 3, after an attempt: true if a joint exceeded its strength. Then the step is to be tried
  // again with the resistance that this leaves. Where six rounds do not end it, the budget ends, or the
  // step would have to be shortened, the pull alone is left. `h` is the whole substep, in its pieces too.
  bool give_in(System& system, Data& data, double h);
  // An attempt is about to be committed, by the trees' shares of it, and pieces follow: what drives have
  // exerted by then counts in them (sub_stepping.h).
  void keep(const System& system, Data& data, const std::vector<double>& share);
  // Adds what the drives exerted in a substep that has ended with state.qvel to their frame's sum.
  void tally(System& system, Data& data, double h);

 private:
  bool exertion(const System& system, Data& data, size_t person, const std::vector<double>& v,
                double h);
  void resist(const System& system, Data& data, size_t person, double h);
  void add_braced(const Drive& d, const Step& step);
  bool less(int at, int count, double most, JointResistance& resistance) const;
  bool share_out(const System& system, Data& data, size_t person, double h);
  void added(const System& system, const Data& data, const Drive& d, double h, const double* x,
             double* out);

  const HeldLoad& load_;
  const InternalForces& internal_;
  std::vector<double> v_star_;           // of the piece under way
  std::vector<char> in_pieces_;          // per person: a piece of the substep has been made
  std::vector<double> kept_;             // what was exerted in those, per dof [N s, N m s]
  std::vector<double> exerted_;          // impulse of the drives, per dof [N s, N m s]
  std::vector<double> change_, pushed_;  // scratch, per dof
  std::vector<double> stiff_;            // X before joints give in, per dof
  std::vector<double> softer_;           // scratch of added()
};

}  // namespace hp
