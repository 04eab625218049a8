// Contact-space solver: Coulomb contacts by block sweeps on A = J M^-1 J^T.
#pragma once
#include <cstdint>
#include <vector>

#include "tree.h"

namespace hp {

// A point that moves with a weighted sum of bodies; a rigid part has one entry.
struct Endpoint {
  static constexpr int kMost = 4;
  int count = 0;
  int body[kMost];
  double weight[kMost];
  Vec3 point[kMost];  // world position of the point carried by each body

  static Endpoint rigid(int body, Vec3 p) {
    Endpoint e;
    if (body > 0) {
      e.count = 1;
      e.body[0] = body, e.weight[0] = 1, e.point[0] = p;
    }
    return e;
  }
};

Vec3 endpoint_velocity(const Model& m, const Kinematics& k, const std::vector<Twist>& twists,
                       const Endpoint& e);

// One contact point between a and b: the rows n, t, s of the relative velocity v_a - v_b.
struct Contact {
  Endpoint a, b;
  Vec3 n, t, s;
  Vec3 position;
  // The points whose gap counts lie this far from `position`, along n on a and against it on b:
  // the surface points, and for rounded shapes the points they are round about.
  double arm_a = 0, arm_b = 0;
  Vec3 rim;           // on a disc: direction from its centre, unit; else zero
  double dist = 0;    // gap at the start of the substep [m]
  double target = 0;  // smallest gap allowed at its end [m]
  double shift = 0;   // correction of the linear prediction [m]: gap_end = dist + h v_n - shift
  double friction = 0, restitution = 0;
  double bounce = -1e300;  // v_n demanded by restitution [m/s], second pass
  Vec3 impulse;            // world [N s], on a; the warm start on entry
  int pair = 0;            // index of the candidate it came from
  int64_t key = 0;         // identity from substep to substep
  int feature = 0;
};

struct SolveReport {
  int sweeps = 0;
  double residual = 0;  // largest violation [m/s]
};

class ContactSolver {
 public:
  // Smallest dv and impulses with  M dv = J^T p  and for every contact, with g the relative
  // normal velocity minus what the contact demands:  0 <= p_n, g >= 0, p_n g = 0,
  // |p_t| <= mu p_n, slip opposed by friction. `v_free` [nv] is the velocity without contact;
  // `v` receives the velocity with it. Stops at `tolerance` [m/s] or `max_sweeps`.
  SolveReport solve(const Model& m, const Kinematics& k, const Inertia& inertia, double h,
                    const double* v_free, double* v, std::vector<Contact>& contacts,
                    double tolerance, int max_sweeps);

 private:
  void half_solve(const Model& m, const Kinematics& k, const Inertia& inertia, int body);
  void sweeps(int n, double tolerance, int most, SolveReport& report);
  void local(int i);
  void normals(int n, double tolerance);
  void product(int n);
  double residual(int n, bool normal_only) const;

  std::vector<double> body_y_;        // per body: chain length x 6
  std::vector<int> body_slot_;        // offset into body_y_, -1: not yet
  std::vector<int> touched_;          // dofs with a row of Y
  std::vector<int> dof_row_;          // dof -> row of Y, -1
  std::vector<double> Y_, A_, beta_, p_, w_, friction_, step_, before_, diagonal_;
  std::vector<Mat3> block_inverse_;
  std::vector<double> tangent_step_;
  std::vector<Twist> twists_;
  // of normals()
  std::vector<double> q_, x_, chol_;
  std::vector<char> active_, wrong_;
  std::vector<int> set_;
};

}  // namespace hp
