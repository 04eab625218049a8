// Trees of rigid bodies: their kinematics (Featherstone 2008, ch. 4).
//
// Conventions are MuJoCo's, so that its models can be read as they are: body 0 is the world, a
// free joint has 7 coordinates (position, quaternion wxyz) and 6 velocities (linear in the world
// frame, angular in the body's own), a ball joint 4 and 3 (angular velocity in the child's frame).
#pragma once
#include <vector>

#include "math/vec.h"

namespace hp {

enum class Joint : int { Free = 0, Ball = 1, Slide = 2, Hinge = 3 };
inline int qpos_width(Joint j) { return j == Joint::Free ? 7 : j == Joint::Ball ? 4 : 1; }

struct Model {
  int nbody = 0, njnt = 0, nq = 0, nv = 0;
  // per body
  std::vector<int> parent, jnt_first, jnt_count, dof_first, dof_count;
  std::vector<Vec3> pos, ipos, inertia;  // offset in the parent, centre of mass, principal moments
  std::vector<Quat> quat, iquat;
  std::vector<double> mass;
  // per joint
  std::vector<Joint> jnt_type;
  std::vector<int> jnt_qpos, jnt_dof, jnt_body;
  std::vector<Vec3> jnt_pos, jnt_axis;
  std::vector<double> qpos0;
  // per velocity degree of freedom
  std::vector<double> armature;

  // Derived by finish():
  std::vector<int> root;  // per body: the body of its tree that hangs on the world
  // The trees that hang on the world: their bodies and dofs, which follow each other.
  struct Tree {
    int first, last;         // bodies
    int first_dof, dof_end;  // of all dofs, one past the last
  };
  std::vector<Tree> trees;
  std::vector<int> last_dof;             // per body: last dof that moves it, -1: fixed
  std::vector<double> carried;           // per body: mass of it and all that hangs on it [kg]
  std::vector<int> dof_body;             // per dof
  std::vector<int> row_start, row_size;  // per dof: its chain of ancestors, itself last
  std::vector<int> chain;                // dof indices of all rows, one after the other
  std::vector<char> plain_ball;          // per body: one ball joint at its origin, no turn at rest
  // Per body: its velocity is given, whatever touches it (stepping/kinematic_bodies.h).
  std::vector<char> held;
  // The last dof by which contacts move a body, -1: none.
  int pushed_dof(int body) const { return held[body] ? -1 : last_dof[body]; }

  void finish();         // throws std::invalid_argument on inconsistent arrays
  void add_up_masses();  // what follows from masses alone
};

// Spatial vector about the tree's reference point: angular part, then linear.
struct Twist {
  Vec3 w, v;
};

inline Twist operator+(Twist a, Twist b) { return {a.w + b.w, a.v + b.v}; }
inline double dot(Twist a, Twist b) { return dot(a.w, b.w) + dot(a.v, b.v); }
inline Twist scaled(double s, Twist a) { return {s * a.w, s * a.v}; }
// Of a motion that is carried along by another one.
inline Twist cross_motion(Twist v, Twist s) {
  return {cross(v.w, s.w), cross(v.w, s.v) + cross(v.v, s.w)};
}

// Everything that follows from a pose.
struct Kinematics {
  std::vector<Vec3> xpos;  // body frame in the world
  std::vector<Quat> xquat;
  std::vector<Mat3> xmat;
  std::vector<Twist> cdof;  // per dof, about the frame origin of its tree's root body

  void resize(const Model& m);
  // Body frames; with `active` (per body, of the tree that it belongs to) only of those trees.
  void update(const Model& m, const double* qpos, const char* active = nullptr);
  void update_dofs(const Model& m, const double* qpos, const char* active = nullptr);  // cdof
  Vec3 reference(const Model& m, int body) const { return xpos[m.root[body]]; }
};

// Spatial velocity of every body about its tree's reference point.
void body_twists(const Model& m, const Kinematics& k, const double* qvel, std::vector<Twist>& out);

// From its parent's velocity and acceleration to those of a body, if `qvel` stays as it is: axes are
// carried along by what comes before them in the chain; those that a free joint shifts along stand
// still.
void carry(const Model& m, const Kinematics& k, const double* qvel, int body, Twist& velocity,
           Twist& acceleration);

// qpos <- qpos moved along qvel for a time t, on the manifold; with `active` only those trees.
void integrate(const Model& m, double* qpos, const double* qvel, double t,
               const char* active = nullptr);

}  // namespace hp
