// The data of a simulation: its state, the substep and the contact problem under way, and the
// results of a frame. Components of the substep take those of these structs that they read and
// write.
#pragma once
#include <algorithm>
#include <vector>

#include "stepping/contact_cache.h"
#include "stepping/effective_inertia.h"
#include "stepping/islands.h"
#include "stepping/soft_contacts.h"
#include "stepping/step_budget.h"
#include "stepping/system.h"

namespace hp {

// Where everything is and how it moves. Invariant: `pose` is the pose of `qpos` where `pose_known`.
struct State {
  std::vector<double> qpos, qvel;
  // Per body: it lies between a root and a part that started inside something.
  std::vector<char> exit_path;
  Poses pose;
  bool pose_known = false;

  // Makes `pose` the pose of `qpos`; all trees are active then.
  void update_pose(System& system);
};

// One substep, or a piece of it. Velocities are of mid-substep: qpos moves by them.
struct Step {
  double length = 0;  // of the whole substep [s]
  // How long gravity has acted in v_free since the pose that a step starts from [s].
  double gravity_time = 0;
  std::vector<double> v_free;      // v*: velocity without contact
  std::vector<double> v;           // velocity with contact
  std::vector<double> spin;        // what qvel at the end differs from v by, of objects that spin
  std::vector<double> joint_pull;  // change of articulated dofs' velocity by forces
  std::vector<double> load;        // change of v_free by people who stand on things; empty: none
  // Per dof: what joints that self-contact does not move hold against it (self_response.h) [N s, N m s];
  // empty: there is none.
  std::vector<double> braced;
  std::vector<char> pushed;  // per body: contacts have pushed it, or a body that hangs on it
  JointResistance resistance;
  int index = 0;     // of the whole substep in its frame
  bool last = true;  // it is the last one of its frame
  // Per root body: how far ranges of joints have given way, in the attempt and by its start.
  std::vector<int> yielded, yielded_before;
  const double* host_v_free = nullptr;  // velocities without contact that a host has found
  Poses end;                            // the pose after the step
  std::vector<double> end_qpos;

  // The end pose of moving with velocities `vel` for h: its coordinates, then its kinematics.
  void move(const System& system, const State& state, const std::vector<double>& vel, double h) {
    find_end(system, state, vel, h);
    pose_end(system, vel, h);
  }
  void find_end(const System& system, const State& state, const std::vector<double>& vel, double h);
  void pose_end(const System& system, const std::vector<double>& vel, double h);
  // Per shape: no point of it goes farther from the state's pose to the end pose [m].
  const std::vector<double>& way(const System& system, const State& state);

 private:
  std::vector<double> way_;
  uint64_t way_stamp_ = 0;  // of the end pose that it leads to
};

// A row that keeps one angle of a person's joint off one end of its range (joint_ranges.h).
struct RangeRow {
  int person = 0, ball = 0, axis = 0;
  double sign = 1;   // 1: off the lower end, -1: the upper
  double limit = 0;  // that end [rad]
  double about = 0;  // a twist is counted as the nearest to this [rad]
  Quat at;           // the joint's rotation that the row is linear at
  std::shared_ptr<std::vector<Endpoint::Bend>> rates;
  Contact contact;  // its row, which moves with `rates`
};

// Friction of somebody who stands on a movable thing (standing_friction.h).
struct StandingRow {
  int shape = 0, person = 0;  // shapes: the thing's, and the person's that presses on it
  Vec3 sole;                  // how fast that goes along the ground [m/s]
  Contact contact;            // on the thing alone, without a normal
};

// The contact problem of one attempt at a step.
struct Attempt {
  std::vector<ContactCandidate> candidates;  // separating planes and pairs of shapes within reach
  size_t listed = 0;                         // candidates that there were at first
  std::vector<int> hidden;  // candidates, one a pair, behind whose crossed planes is to be searched
  std::vector<Contact> contacts;  // contact points
  std::vector<Contact> limits;    // rows of joint ranges, solved with the contacts
  std::vector<RangeRow> ranges;   // rows of people's joints, solved with the contacts
  // Rows of things under people, likewise.
  std::vector<StandingRow> standing;
  std::vector<double> reach;   // per shape: how far candidates are looked for [m]
  std::vector<double> valid;   // per shape: how far they hold, at most that [m]
  std::vector<char> violated;  // per candidate: the end pose misses its target
  std::vector<double> excess;  // per candidate: its gap minus its target [m]
  std::vector<char> relaxed;   // per root body: the clearance of its island has been given up
  double worst = 0;            // the largest violation [m], negative
  std::vector<IslandProgress> islands;  // per root body that names one
  size_t solved = 0;                    // number of contacts that the last solve knew
  bool good = true;  // no candidate is violated at the end pose: all have settled

  bool settled(int island) const { return islands[island].state == IslandProgress::State::Settled; }

  // Candidates that have a plane. The others are bounds, which cost next to nothing.
  size_t planes() const {
    return std::count_if(candidates.begin(), candidates.end(),
                         [](const ContactCandidate& c) { return c.known == Known::Plane; });
  }
};

// Contact of two shapes in a frame, summed over its substeps; position and normal weighted by
// impulse.
struct Touch {
  int shape = 0, other_static = -1, other_shape = -1;
  Vec3 position, normal, impulse;
  double weight = 0;
};

struct Diagnostics {  // of one frame
  int candidates = 0, contacts = 0, passes = 0, sweeps = 0, shortened = 0;
  double residual = 0;  // largest gap missing at the end of a substep [m]
  // Largest miss of Coulomb's law of friction in the solve that a step was made with [m/s], and in
  // tolerances of the solver.
  double friction = 0, friction_tolerances = 0;
  double lost_time = 0;  // [s]
};

// A sample under pressure at the end of a frame.
struct SoftPoint {
  int layer_static = -1,
      layer_shape = -1;       // what is pressed; -1: the other, or a shape's own layer
  int shape = 0, sample = 0;  // what presses, by the caller's number
  Vec3 position, normal;      // of the sample; from the layer outward, unit
  double depth = 0, pressure = 0, area = 0;  // [m], [Pa], projected [m^2]
};

struct FrameResult {
  std::vector<Touch> touches;
  std::vector<SoftPoint> soft;
  // Every contact point that carried an impulse, one by one, where somebody asks for them.
  struct Point {
    int shape, other_static, other_shape;
    Vec3 position, normal, impulse;  // the impulse on `shape` [N s]
    double dist;                     // gap at the start of the substep [m]
  };
  bool keep_points = false;
  std::vector<Point> points;
  Diagnostics diagnostics;
  std::vector<char> disturbed;   // per root body: contacts have acted on its tree
  std::vector<Breach> breaches;  // overlaps that should not be, at any committed pose; the deepest

  void clear(int nbody);
  void add(const ContactCandidate& candidate, const Contact& contact);
  void add(const Breach& breach);
};

// Records for tests and measurements. None of it changes a simulation but `keep_pieces` and `blind`.
struct Probe {
  // The last substep's problem and answer, for comparison with the reference implementation.
  struct Trace {
    std::vector<double> qpos, qvel, v_free, v;
    std::vector<Contact> contacts;
    std::vector<RangeRow> ranges;
    std::vector<char> touched;
    double h = 0;
    int k = 0;
    // Velocities (nv each) of the rounds before the last, in which a joint exceeded its strength.
    std::vector<double> overcome;
  };
  bool keep_trace = false;
  bool tracing = false;  // this attempt is one at the whole substep
  Trace trace;
  // Recorded poses include those of every piece of a substep; every person is stepped through then.
  bool keep_pieces = false;
  std::vector<double>* pieces = nullptr;  // of the frame under way
  // For tests of the end check: no step has candidates (1), nor is any refused for its end (2).
  int blind = 0;
  // Wall time of the solver in every substep since the last reset [s].
  bool keep_times = false;
  std::vector<double> solve_times;
};

struct Data {
  State state;
  Step step;
  Attempt attempt;
  EffectiveInertia inertia;
  ContactCache cache;
  Islands islands;
  SoftContacts soft;
  StepBudget budget;
  FrameResult result;
  Probe probe;

  void finish(const System& system);
  // The budget has ended, and this island had its part of the last attempt: no more for its sake.
  bool spent(int island) const {
    return budget.out() && budget.attempt_out(attempt.islands[island].work);
  }
};

// Normal component of the relative velocity at a contact [m/s].
double approach(const Model& m, const Kinematics& k, const Contact& c,
                const std::vector<Twist>& twists, const std::vector<double>& v);

}  // namespace hp
