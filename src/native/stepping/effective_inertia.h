// The effective inertia M^ with which trees resist contact impulses, and its factor.
//
//   M^ = s (M + X),   M^ (v - v*) = J^T p
//
// M is the joint-space inertia [kg, kg m^2]. On a person's rows s and X come from the drive:
// s = (1 + h/tau)^2, X = lambda diag(I) (docs/physics.md, "The drive"; PJSC of the paper). To X add
//   - the damping and springs of articulations, h D + h^2 K, and of the host's joints, h D;
//   - what JointResistance asks for: joints that exceed their strength resist less (strength.h),
//     joints that nothing touches more (untouched_joints.h);
//   - the firmness of bodies that come out of an initial overlap (exit_motion.h);
//   - joint damping as a baseline (baselines/internal_forces.h).
// M is composed once per pose; M^ is factored once per set of resistances, where it is solved with.
#pragma once
#include <vector>

#include "stepping/system.h"

namespace hp {

struct State;
struct Step;

// How joints resist contacts in this substep, beside what the drive's settings say.
struct JointResistance {
  std::vector<int> rounds;      // per drive: rounds in which joints gave in; 0: no `share`
  std::vector<double> share;    // per dof: theta in [0, 1]; M^ - M becomes theta (M^ - M) theta
  std::vector<char> touched;    // per body: contacts push it or what hangs on it, or did
  std::vector<char> holds;      // per drive: joints that nothing touches are held
  std::vector<double> damping;  // per dof, of a host's joints [N s/m, N m s]; empty: no host

  void finish(const Model& m, size_t drives);
  // A substep begins: without contact every joint counts as touched, and all holds are on.
  void begin(const Model& m, size_t drives);
};

class EffectiveInertia {
 public:
  void finish(const Model& m);
  // The pose has changed: M is composed again when it is next needed.
  void forget() { composed_ = false; }
  // A resistance has changed: M^ is made again when it is next needed.
  void refactor() { added_up_ = factored_ = false; }
  // Finds s, M and X at the present pose for a step of length h [s], unless they are known.
  void add_up(const System& system, const State& state, const Step& step, double h);
  // And factors M^, unless that is known.
  void build(const System& system, const State& state, const Step& step, double h);
  // Composes M alone, of the present pose, where it is not known. It is not kept as known.
  void compose(const System& system, State& state);

  const Inertia& inertia() const { return inertia_; }          // M
  const InertiaFactor& factor() const { return factor_; }      // of M^
  const std::vector<double>& scale() const { return scale_; }  // s, per dof
  // X of the drives and articulations alone, per dof.
  const std::vector<double>& drive_part() const { return drive_; }
  // X as it was last, per dof of people.
  const std::vector<double>& added() const { return added_; }
  // out = M x on the rows of one person. Products of this pose are kept: the same is asked again.
  void multiply(const System& system, const Drive& d, const double* x, double* out) const;
  void solve(const Model& m, double* x) const { factor_.solve(m, x); }  // x <- M^^-1 x

 private:
  void add_drives(const System& system, const JointResistance& r, double h);
  void hold_untouched(const System& system, const JointResistance& r);
  void stiffen_exits(const System& system, const State& state);
  void damp_joints(const System& system, double h);
  void drop_products();

  struct Product {
    int root = 0;               // body, 0: none
    std::vector<double> x, Mx;  // of its tree's dofs
  };
  static constexpr int kProducts = 4;

  Inertia inertia_;
  mutable Product products_[kProducts];
  mutable int next_product_ = 0;
  InertiaFactor factor_;
  std::vector<double> scale_, drive_, total_, added_;
  bool composed_ = false, added_up_ = false, factored_ = false;
};

}  // namespace hp
