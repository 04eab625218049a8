// What moves and can be touched: rigid parts, objects, and hulls of a person's skin.
#pragma once
#include <algorithm>
#include <memory>
#include <vector>

#include "geometry/convex.h"
#include "contact/solver.h"
#include "dynamics/kinematic_tree.h"

namespace hp {

// A person's skin: vertices that hang on several joints each (linear blend skinning with pose blend
// shapes, SMPL, Loper et al. 2015):  x = sum_j w_j (R_j (rest + B vec(R_local - I) - j_j) + c_j).
struct Skin {
  std::vector<int> body, parent, dof;  // of each joint: the model's body, the parent joint, first dof
  std::vector<Vec3> joint;        // at rest
  std::vector<Vec3> rest;         // vertices at rest
  std::vector<int> first, at;     // vertex v hangs on the joints at[first[v]] ... at[first[v + 1] - 1]
  std::vector<double> weight;
  std::vector<double> bend;  // vertices x 3 x 9 (joints - 1), empty: no pose blend shapes
  int features() const { return 9 * ((int)joint.size() - 1); }
};

// A convex shape carried by a body: a part of a person, or an object. Or one whose vertices are
// vertices of a skin.
struct CollisionShape {
  // Every point is a weighted mean of points carried by these bodies, each no farther than `reach`
  // from `anchor`, with a weight of at most `most`. The first carries most.
  struct Tie {
    int body;
    double most;
    Vec3 anchor;  // body's frame
    double reach;
    Vec3 middle;  // where the body carries the shape's centre; body's frame
  };
  Convex shape;  // of a skin: at rest
  int body = 0;
  int name = 0;     // index into the names
  int person = -1;  // -1: an object
  int part = -1;    // joint index, -1: an object
  double slack = 0;  // how far it sticks out of the surface that it stands for [m]
  std::shared_ptr<const Skin> skin;
  std::vector<int> vertex;  // of the skin
  std::vector<Tie> ties;
  std::vector<double> weights;  // of a skin: ties x vertices
  struct Run {  // of vertices that hang on a tie
    int tie, first, count;
  };
  std::vector<Run> runs;  // tie after tie
  // Pose blend shapes: no vertex goes farther than `most` times the change of the joint's local
  // rotation matrix (Frobenius).
  struct Stretch {
    int joint;
    double most;
  };
  std::vector<Stretch> stretches;

  void finish();

  // Upper bound of a weighted mean over a point's ties, of what `of` says for each.
  template <typename Of>
  double most_of(Of of) const {
    const double first = of(ties[0]);
    double most = first, sum = first;
    for (size_t k = 1; k < ties.size(); k++) {
      const double d = of(ties[k]);
      if (d > first) sum += ties[k].most * (d - first);
      most = std::max(most, d);
    }
    return std::min(most, sum);
  }
};

// Poses of all shapes.
struct Poses {
  unsigned stamp = 0;  // another one, another pose
  Kinematics kin;
  std::vector<PosedShape> placed;
  std::vector<char> fresh;
  // Of skins with pose blend shapes: entries of the local rotations, minus the identity.
  struct Bends {
    const Skin* skin;
    std::vector<double> features;
  };
  std::vector<Bends> bends;

  void place(const std::vector<CollisionShape>& shapes, int i);
  const std::vector<double>& features(const Skin& s);
  // A sphere that holds all of a shape.
  struct Ball {
    Vec3 center;
    double radius;
  };
  Ball ball(const CollisionShape& m) const;
  const Ball& known_ball(const std::vector<CollisionShape>& shapes, int i);  // found once
  std::vector<Ball> balls;  // a negative radius: not yet
  // A point of a shape's surface, now at x, and where it is at this pose. The shape must be placed.
  Material material(const CollisionShape& m, const PosedShape& at, Vec3 x) const;
  Vec3 position(const CollisionShape& m, const PosedShape& at, const Material& point) const;
  Endpoint endpoint(const CollisionShape& m, const PosedShape& at, const Material& point) const;
};

// How far no point of each shape goes between two poses, for those of active bodies [m].
void ways(const std::vector<CollisionShape>& shapes, const Poses& from, const Poses& to,
          const std::vector<char>& active, std::vector<double>& way);

}  // namespace hp
