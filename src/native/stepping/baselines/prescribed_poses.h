// Baseline: people whose poses are prescribed (docs/physics.md, "Poses that are set").
//
// To contacts such people are trees that stand, of infinite mass and with no velocity: a body whose
// state is overwritten has none. Static geometry and other people are not in their way. Objects
// that they overlap are found anew wherever people are put, hull by hull, and leave along the
// direction of least overlap at Settings.depenetration_speed at most; where objects have no room
// they stay overlapped.
//
// No push makes an object faster than kThrownFactor times that speed, or than it was and that speed
// at right angles. A try at a step that does is repeated with a gentler push (PrescribedExits::pace
// in [0, 1] is its share of the speed). Objects without room are not pushed for some time; those
// that are thrown even so are jammed: they stand still in the substep.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

class Substep;

class PrescribedPoses {
 public:
  void finish(const Model& m) { push_.assign(m.nbody, {}); }
  void reset(System& system);
  // One frame of length dt in n substeps, as Stepper::frame.
  void frame(System& system, Data& data, Substep& substep, const double* targets, double dt, int n,
             std::vector<double>* poses);

  // After a try at a step: false if it is to be repeated, with other pushes.
  bool accept(System& system, Data& data, int tries);
  // The tries have ended: jammed objects move again.
  void release_jammed(Model& m);

  // Per body: the world's pace and the waits.
  void save(const World& world, std::vector<double>& out) const;
  const double* load(World& world, const double* in);

 private:
  // Of an object that had no room to leave: how long it is not pushed, and will not be the next
  // time [s].
  struct Push {
    double wait = 0, patience = 0;
  };
  void stand_aside(System& system) const;
  void put_people(System& system, Data& data, double share);
  void gain_pace(World& world, double h);
  double fastest(const System& system, const Kinematics& k, int body,
                 const std::vector<Twist>& twists) const;
  bool soften(System& system, Data& data, int body, int tries);
  void jam(System& system, Step& step, int tree);

  std::vector<Push> push_;   // per body
  std::vector<int> jammed_;  // bodies, in the attempt under way
  std::vector<Twist> twists_, free_;
  std::vector<double> way_;
};

}  // namespace hp
