// Rows of the solver for what one body presses on one layer with.
//
// The pairs of a group (soft_pairs.h) press together: their samples under pressure are condensed into a few
// points (soft/condensation.h). A point on a skin is the mean of the samples of its patch, by their loads:
// it moves with the bodies that carry those, each by its share.
#pragma once
#include <vector>

#include "soft/condensation.h"
#include "stepping/soft_pairs.h"

namespace hp {

// What one body of a group presses with.
struct BodyLoad {
  int body = 0, candidate = 0;  // that it is recorded as
  double share = 0;             // of the group's load
  Vec3 x;                       // its mean place [m]
};

// A group in one solve.
struct GroupRows {
  std::vector<const SoftPair*> members;
  std::vector<int> candidates;  // of each
  PressedSamples pressed;
  // What takes places of the pose that samples were looked at to that of the start.
  Vec3 back;
  Vec3 along;                   // friction that is expected, an impulse [N s]
  std::vector<BodyLoad> loads;  // of a step that is recorded, if there is more than one

  void clear() { members.clear(), candidates.clear(), pressed.clear(); }
};

// Does one body press alone?
bool of_one_body(const System& system, const GroupRows& group);
// Finds the loads of several, by the samples under pressure.
void find_loads(const System& system, GroupRows& group);

class RowMaker {
 public:
  // Appends rows that lie on the bodies at `start`. `approach(contact)` is the speed at which the two
  // part where the samples were looked at [m/s].
  template <typename Approach>
  void make(const System& system, Poses& start, Rule rule, double least_turn, GroupRows& group,
            const Approach& approach, std::vector<Contact>& rows) {
    points_.clear();
    condense(group.pressed, least_turn, points_);
    for (const PatchPoint& p : points_) {
      Contact c = row(system, start, rule, group, p);
      c.compliance = 1 / p.yield;
      c.yielding = approach(c) + p.impulse / p.yield;
      rows.push_back(c);
    }
  }

 private:
  // Sums over samples of what a joint carries of them.
  struct Carried {
    double sum[4] = {};  // of weighted places at rest, and of weights
    Vec3 at;             // where their mean is [m]
    double weight() const { return sum[3]; }
  };
  void add(const SurfaceSamples::Carrier* by, const SurfaceSamples::Four* weighted, int count,
           double load);
  void carry(const System& system, Poses& start, const GroupRows& group, int patch);
  Contact row(const System& system, Poses& start, Rule rule, const GroupRows& group,
              const PatchPoint& point);
  Endpoint mean_point(const System& system, Poses& start, const GroupRows& group, int patch,
                      Vec3 x);

  std::vector<PatchPoint> points_;
  std::vector<Carried> carried_;  // per joint, zero between uses
  std::vector<int> joints_;
  std::vector<SurfaceSamples::Four> weighted_;  // of one sample of what bends
};

}  // namespace hp
