// The world of another engine (docs/physics.md, "In another program's MuJoCo world"): its arrays, as
// it lays them out, and what is done to them.
//
// The core's model begins with the host's bodies, in their order, and with its coordinates, under the
// numbers that they have there; people come after them. In the host a person is a set of bodies without joints, whose poses
// are written (MuJoCo's mocap bodies): its mirror.
#pragma once
#include <vector>

#include "dynamics/kinematic_tree.h"

namespace hp {

// Arrays of the host; it owns them.
struct Host {
  int nq = 0, nv = 0;
  std::vector<int> bodies;  // the host's numbers of the core's bodies 1, 2, ...
  double *qpos = nullptr, *qvel = nullptr, *qacc = nullptr;
  const double* damping = nullptr;  // of joints, implicit, per dof
  const double* xipos =
      nullptr;                // centres of mass of all its bodies (., 3) [m], as it last found them
  double* applied = nullptr;  // forces and torques on bodies at xipos (., 6) [N, N m]
  double *mocap_pos = nullptr, *mocap_quat = nullptr;

  struct Mirror {
    int body;   // of a person
    int mocap;  // row of mocap_pos and mocap_quat
  };
  std::vector<Mirror> mirrors;

  bool owns(int body) const { return body > 0 && body <= (int)bodies.size(); }
  int number(int body) const { return bodies[body - 1]; }
  // Writes the people's poses.
  void show(const Kinematics& kin) const;
};

// Forces of ours among those that a host applies to its bodies: added for a while, then taken back
// exactly. A number that somebody else has written meanwhile is theirs, and stays.
class AppliedForces {
 public:
  // On a body of the host, by its number there, whose centre of mass is at `centre`.
  void add(const Host& host, int body, Vec3 centre, Vec3 at, Vec3 force);
  void remove(const Host& host);
  // Rows of 13: the body, its row without ours and with them.
  std::vector<double> save() const;
  void load(const std::vector<double>& rows);

 private:
  struct Row {
    int body;
    double before[6], after[6];
  };
  std::vector<Row> rows_;
};

}  // namespace hp
