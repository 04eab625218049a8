// Contacts between bodies: from the joints' velocities to contact space and back.
//
// In a substep of length h contacts make of the free velocity v* [nv] the velocity v with
//     M (v - v*) = J^T p,
// M the inertia matrix in joint space (of people with what their drives resist, docs/physics.md, "The
// solver"), J the Jacobian of all contacts' relative velocities, and p the impulses [N s]. Each
// contact demands of the linear prediction of its gap
//     gap_end = dist + h w_n - shift >= target,
// `shift` being what the true end pose showed the prediction to be off by, and obeys Coulomb's law
// with that: contact_problem.h.
//
// From M = L^T D L (inertia_factor.h) follow the sparse rows of Y = D^-1/2 L^-T J^T, by one half of a
// solve per contact, along the chains of the bodies that it touches (half_solve.h); then
//     A = J M^-1 J^T = Y Y^T                                            (the Delassus operator),
// and the answer is v = v* + L^-1 D^-1/2 Y^T p.
//
// Islands (trees that contacts connect) are solved one by one: what rests in one corner does not feel
// how well another is solved. Within an island only those contacts take part that carry something:
// those that did so in the substep before, and the worst of each pair. The others are looked at in
// view of the answer, and join where they are violated; A then grows by their rows.
//
// Every island has a budget of contacts and of work (tuning.h, kMostJoined, kSolveWork). Where it ends
// before the tolerance is reached, the report says so: the answer is then the best so far. Gaps are verified
// afterwards, so that what is missing of them shortens the step; what is missing of friction is reported.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "contact/contact_problem.h"
#include "dynamics/half_solve.h"
#include "tuning.h"

namespace hp {

// A point that moves with a weighted sum of bodies; a rigid part has one entry, a skinned vertex
// several.
struct Endpoint {
  static constexpr int kMost = 8;
  // What a joint's velocity does to the point besides: pose blend shapes.
  struct Bend {
    int dof;
    Vec3 rate;  // of the point, world
  };
  int count = 0;
  int body[kMost];
  double weight[kMost];
  Vec3 point[kMost];  // world position of the point carried by each body
  std::shared_ptr<const std::vector<Bend>> bends;  // often none

  static Endpoint rigid(int body, Vec3 p) {
    Endpoint e;
    if (body > 0) {
      e.count = 1;
      e.body[0] = body, e.weight[0] = 1, e.point[0] = p;
    }
    return e;
  }
};

// A point of a surface, to be found again at another pose: `local` in its body's frame, or, of a skin,
// off the vertex that it moves with, before that is posed.
struct Material {
  int vertex = -1;
  Vec3 local;
};

// `twists` are those that the velocities `qvel` make.
Vec3 endpoint_velocity(const Model& m, const Kinematics& k, const std::vector<Twist>& twists,
                       const double* qvel, const Endpoint& e);
// The angular velocity with which what lies near the point moves past it.
Vec3 endpoint_turn(const std::vector<Twist>& twists, const Endpoint& e);

// One contact point between a and b: the rows n, t, s of the relative velocity v_a - v_b.
struct Contact {
  Endpoint a, b;
  Vec3 n, t, s;
  Vec3 position, at_a, at_b;
  // Material points between which the gap is measured: surface points, or the core points of
  // rounded shapes.
  Material gap_a, gap_b;
  // Amount by which the gap shrinks because a displaced shape returns from its displacement [m].
  double closing = 0;
  Vec3 rim;           // on a disc: direction from its centre, unit; else zero
  double dist = 0;    // gap at the start of the substep [m]
  double target = 0;  // smallest gap allowed at its end [m]
  double shift = 0;   // correction of the linear prediction [m]: gap_end = dist + h v_n - shift
  // Half of the point's relative acceleration along its path [m/s^2]. Its tangential part counts:
  // displacement_t = h v_t + h^2 curve_t; the gap itself is measured at the end pose.
  Vec3 curve;
  // Friction acts at the point plus this, across n [m]; the normal impulse at the point
  // (collision/friction_places.h). `spread` of its patch; 0: not known. `placed`: it has been found.
  Vec3 inward;
  double spread = 0;
  bool placed = false;
  double friction = 0, restitution = 0;
  double bounce = -1e300;  // v_n demanded by restitution [m/s], second pass
  double rebound = 0;      // what of it is thrown back, not kept [m/s]
  // Of a soft layer, and of what stands on a thing (stepping/standing_friction.h): the row is w_n + compliance p_n >= yielding instead, so that p_n = (yielding - w_n)/compliance
  // where that pushes; 0: hard.
  double compliance = 0;  // [1/kg]
  double yielding = 0;    // [m/s]
  Vec3 impulse;           // world [N s], on a; the warm start on entry
  int pair = 0;           // index of the candidate it came from
  int64_t key = 0;        // identity from substep to substep
  int feature = 0;
};

// v_a - v_b at the point, and where friction acts.
struct ContactVelocity {
  Vec3 point, slip;
};
ContactVelocity contact_velocity(const Model& m, const Kinematics& k,
                                 const std::vector<Twist>& twists, const double* qvel,
                                 const Contact& c);

class ContactSolver {
 public:
  // Writes the velocity with contact into `v` and impulses into `contacts`, whose impulses on entry
  // are the warm start. Stops at `tolerance` [m/s] or `max_sweeps`. `mass` [kg] of all that moves,
  // where a body on a track may squeeze others: else 0. `budget` [multiplications] is each island's.
  SolveReport solve(const Model& m, const Kinematics& k, const InertiaFactor& inertia, double h,
                    const double* v_free, double* v, std::vector<Contact>& contacts,
                    double tolerance, int max_sweeps, double mass = 0,
                    double budget = tuning::contact::kSolveWork);

 private:
  // The model at one pose, its inertia factored.
  struct System {
    const Model& m;
    const Kinematics& k;
    const InertiaFactor& inertia;
  };
  struct Island {
    const int* contact;  // indices of its contacts
    int count;
    double tolerance;  // [m/s]
    int max_sweeps;
    double mass, budget;
  };
  // A contact that takes part: its row of Y, sparse over dofs.
  struct Row {
    int contact = 0;
    int first = 0, count = 0;  // into dof_, y_
  };
  // A contact that may join.
  struct Waiting {
    int contact, pair;
    double violation;
  };

  void find_demands(const System& s, double h, const double* v_free,
                    const std::vector<Contact>& contacts);
  void find_islands(const Model& m, const std::vector<Contact>& contacts);
  int island_of(int root);
  static int any_root(const Model& m, const Contact& c);
  void solve_island(const System& s, const Island& at, std::vector<Contact>& contacts,
                    SolveReport& report);
  bool crushes(const Island& at) const;
  void response(const System& s);

  bool join_first(const System& s, const Island& at, const std::vector<Contact>& contacts);
  bool join_violated(const System& s, const Island& at, const std::vector<Contact>& contacts);
  template <typename Violation>
  bool join_worst(const System& s, const Island& at, const std::vector<Contact>& contacts,
                  const Violation& violation);
  template <typename Violation>
  void find_worst(const Island& at, const std::vector<Contact>& contacts,
                  const Violation& violation);
  bool has_room() const { return (int)rows_.size() < tuning::contact::kMostJoined; }
  void join(const System& s, const Contact& c, int contact);
  void push(const System& s, const Endpoint& e, double sign, const Contact& c);
  void fill_blocks(int n);

  // of the whole solve
  HalfSolve half_;
  std::vector<Twist> twists_, response_;
  std::vector<double> dv_, demand_;
  bool answered_ = false;  // dv_ is what the impulses of the island that was solved make
  std::vector<int> root_island_, order_;
  std::vector<char> joined_;
  // of the island
  ContactProblem problem_;
  std::vector<Row> rows_;
  std::vector<int> dof_;
  std::vector<double> y_;        // three per entry of dof_, and a zero
  std::vector<double> scatter_;  // nv x 4, zero between uses
  std::vector<Waiting> worst_;
  std::vector<int> worst_of_pair_;  // two per pair: into worst_; -1 between uses
  bool shut_out_ = false;           // a contact that is violated did not join: the budget had ended
};

}  // namespace hp
