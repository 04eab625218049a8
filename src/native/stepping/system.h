// The system that is simulated: trees, shapes, drives and settings (MuJoCo's mjModel;
// stepping/data.h is its mjData).
//
// Bodies form trees that hang on body 0, the world. A tree is a person (a free root and ball
// joints, moved by a Drive), an object (one body with a free joint) or an articulation (any other
// tree). Kinematic bodies are objects with a trajectory.
#pragma once
#include <memory>
#include <vector>

#include "collision/world.h"
#include "dynamics/articulation.h"
#include "soft/soft_world.h"
#include "stepping/drive.h"

namespace hp {

// How the reference motion acts on people: by velocity (half-physics) or, as baselines, by poses
// that are prescribed: once a frame without contacts, once a frame, or in every substep
// (baselines/prescribed_poses.h).
enum class Prescribed { No = 0, Kinematic = 1, Positions = 2, Interpolated = 3 };

struct System {
  Model model;
  World world;
  SoftWorld soft;
  Articulations articulations;
  DriveSettings drive_settings;
  Vec3 gravity{0, 0, -9.81};      // [m/s^2]
  double clearance_range = 0.05;  // up to which clearances are measured [m]
  Prescribed prescribed = Prescribed::No;
  std::vector<std::shared_ptr<const Skin>> skins;
  std::vector<int> start_asleep;  // objects that sleep after a reset

  // Derived by finish():
  std::vector<Drive> drives;        // one per person
  std::vector<char> person;         // per body: it is the root of a person
  std::vector<char> holds_load;     // per body: a held object, or its holder's root
  std::vector<int> objects;         // bodies that are objects
  std::vector<double> joint_reach;  // per body: of the farthest point that its joint moves [m]

  // Call when model and world are filled. `person_roots`: the root body of every person.
  // Throws std::invalid_argument where the arrays do not describe such a system.
  void finish(const std::vector<int>& person_roots);

  bool is_person(int body) const { return person[model.root[body]]; }
  bool is_object(const ContactCandidate& c) const {  // at least one side is no person
    return !is_person(world.shapes[c.shape].body) ||
           (c.other_shape >= 0 && !is_person(world.shapes[c.other_shape].body));
  }
  int tree(int shape) const { return model.root[world.shapes[shape].body]; }
  bool active(const Drive& d) const { return world.active[d.body(0)]; }
  bool carries(const Drive& d) const { return holds_load[d.body(0)]; }
  // A candidate between overlapping shapes of one person: self-contact that separates.
  bool self_overlap(const ContactCandidate& c) const {
    return c.dist < 0 && c.other_shape >= 0 && tree(c.shape) == tree(c.other_shape);
  }
  // Number of ball joints of all people, roots included.
  int ball_count() const;
  // Upper bound of the speed of all points of a shape at the pose `k` and the bodies' velocities
  // `t` [m/s].
  double speed_bound(const Kinematics& k, const CollisionShape& shape,
                     const std::vector<Twist>& t) const;

 private:
  void find_objects();
  void find_loads();
  void find_joint_reach();
};

}  // namespace hp
