// Rows of Y = D^-1/2 L^-T J^T, three at a time, sparse over dofs: what unit impulses along the three
// axes of a contact do, dof by dof.
//
// J^T is given as wrenches on bodies, about their tree's reference point, and as generalised forces on
// single dofs. A sweep from the leaves to the roots, along the bodies that they reach only, takes of the
// wrench what each dof gives way to (inertia_factor.h) and hands the rest to the parent:
//     x = f + S.P,   P <- P - K x,   y = D^-1/2 x.
#pragma once
#include <vector>

#include "dynamics/inertia_factor.h"

namespace hp {

class HalfSolve {
 public:
  // Clears what has been collected.
  void begin(const Model& m);
  // Adds to what acts on a body: moments and forces of the three rows.
  void add_wrench(int body, const Vec3 moment[3], const Vec3 force[3]);
  // The same on one dof.
  void add_force(const Model& m, int dof, const double force[3]);
  // Appends the dofs that are reached, children first, and four numbers for each: the three rows' y,
  // and zero. What was collected is gone then.
  void sweep(const Model& m, const InertiaFactor& factor, std::vector<int>& dofs,
             std::vector<double>& y);

 private:
  void reach(int body);
  void sweep_body(const Model& m, const InertiaFactor& factor, int body, std::vector<int>& dofs,
                  std::vector<double>& y);
  void sweep_chains(const Model& m, const InertiaFactor& factor, size_t first,
                    const std::vector<int>& dofs, std::vector<double>& y);

  std::vector<double> wrench_;  // per body 6 x 4, zero where nothing acts
  std::vector<double> force_;   // per dof 4, zero between uses
  std::vector<char> reached_;   // per body
  int waiting_ = 0, last_ = 0;  // bodies that are reached, and the last of them
};

}  // namespace hp
