// Articulated objects: trees that are neither a person nor one free body, such as doors, drawers and
// robot arms. What moves them without contact, and the limits of their joints.
//
// With c the Coriolis, centrifugal and gravity forces (recursive Newton-Euler, Featherstone 2008, ch.
// 5), D the damping and K the stiffness of joints, the velocity without contact is
//     (M + h D + h^2 K) (v* - v) = h (tau_spring - D v - h K v - c),
// which is implicit in springs and damping: any stiffness is stable (docs/physics.md, "Articulated
// objects"). A limit of a joint is a contact without friction that moves with one dof.
//
// A motor is a spring of a hinge or slide whose rest r moves as it is told, with a damping D against the
// rest's own velocity: it exerts F = K (r - q) + D (dr/dt - v), and its effort at most. Where F is over its effort
// as a step begins it exerts its effort. If F would be so at the end too, by the inertia that its joint has
// alone, nothing of K and D joins the inertia: the joint gets all of it. Else it would be thrown beyond its
// rest, and h D + h^2 K stays: a joint that is stopped presses with its effort either way. Trees with motors
// bear their own weight, as robots' controllers have it: no gravity in c.
#pragma once
#include <algorithm>
#include <vector>

#include "contact/solver.h"
#include "dynamics/inertia.h"

namespace hp {

// What acts in joints, in the order of Model. Empty lists: nothing does.
struct JointForces {
  std::vector<double> damping;       // per dof
  std::vector<double> stiffness;     // per joint
  std::vector<double> spring;        // per coordinate: where the springs rest
  std::vector<char> limited;         // per joint, of hinges and slides
  std::vector<double> lower, upper;  // per joint
  std::vector<double> effort;        // per joint: the most that its spring exerts [N m or N]
  std::vector<double> rate;          // per joint: velocity of its spring's rest [rad/s or m/s]
  std::vector<int> motors;           // joints
};

// Coriolis, centrifugal and gravity forces c of  M dv/dt + c = tau  at the velocity `qvel`, by recursion
// over `bodies`: whole trees, parents first (Featherstone 2008, ch. 5). Writes those bodies' dofs only.
// With `qacc` M qacc + c; with `massive` (per body) as if the others had no mass.
void bias_forces(const Model& m, const Kinematics& k, const double* qvel, Vec3 gravity,
                 const std::vector<int>& bodies, double* out, const double* qacc = nullptr,
                 const std::vector<char>* massive = nullptr);

class Articulations {
 public:
  JointForces joints;

  // `others`: per body, whether its tree is not an articulated object.
  void finish(const Model& m, const std::vector<char>& others);
  // After finish(): these joints (hinges and slides) are motors; `effort` [N m or N] for each.
  void set_motors(const Model& m, const std::vector<int>& motors,
                  const std::vector<double>& effort);
  // Where the springs of the motors rest from now on [rad or m], and how fast that moves.
  void set_rests(const Model& m, const double* rests, const double* rates);
  // A step of length h begins: which motors are at their effort. `own`: M of the pose (its diagonal).
  void find_efforts(const Model& m, const std::vector<char>& active, const Inertia& own,
                    const double* qpos, const double* qvel, double h);
  // Is any of them active?
  bool any(const Model& m, const std::vector<char>& active) const;
  const std::vector<int>& dofs() const { return dofs_; }
  bool jointed(int body) const {  // is it a link of one?
    return std::binary_search(bodies_.begin(), bodies_.end(), body);
  }
  // Damping and springs act with the velocity at the end of the step: h D + h^2 K joins the inertia.
  void added_inertia(const Model& m, const std::vector<char>& active, double h,
                     std::vector<double>& extra) const;
  // h times the force on the dofs of the active trees, into `out`; the other dofs stay as they are.
  void impulse(const Model& m, const Kinematics& k, const std::vector<char>& active, Vec3 gravity,
               const double* qpos, const double* qvel, double h, double* out);
  // A row for either end of every joint that has ends, in the form of a contact that moves with one dof
  // and has no friction: `dist` is how far it still goes.
  void limits(const Model& m, const std::vector<char>& active, const double* qpos,
              std::vector<Contact>& out) const;
  // The largest speed of any joint of an active tree [rad/s].
  double fastest(const Model& m, const std::vector<char>& active, const double* qvel) const;

 private:
  double asked(const Model& m, int joint, const double* qpos) const;

  std::vector<int> bodies_, dofs_, joints_;
  enum class Effort : char { Within, AtFirst, AllAlong };
  std::vector<Effort> effort_;  // per joint: where its motor is at its effort in this step
  std::vector<double> driven_;  // per joint: what a motor at its effort exerts
  std::vector<Contact> ends_;   // two per joint that has ends: the lower first
  std::vector<int> end_joint_;
  std::vector<char> balanced_;  // per body: its tree has motors
  std::vector<int> moving_, moving_balanced_;
  std::vector<double> bias_;
};

// Of a row of `limits`: its dof, and the direction that it leaves its end in.
inline int limit_dof(const Contact& c) { return c.a.bends->front().dof; }
inline double limit_sign(const Contact& c) { return c.a.bends->front().rate.x; }
inline bool is_limit(const Contact& c) { return c.a.count == 0 && c.b.count == 0 && c.a.bends; }

}  // namespace hp
