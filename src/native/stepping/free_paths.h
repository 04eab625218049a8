// Free paths: people who meet nothing on their way to the next frame need no substeps; they arrive
// there (docs/physics.md, "The frame").
//
// A person who is where the motion has it (but for a displaced root) moves with joint rates that
// are constant in the child's frame. A point of a hull stays near the straight line between its
// start and end: with W the sum of the joint speeds along the chain [rad/s] and B that of their
// turning [rad/s^2], a point at r from its frame accelerates by at most A + (W^2 + B) r, A that of
// the frame's origin, and strays at most dt^2/8 times that from the line (the bulge). If the broad
// phase proves the swept hulls clear of everything, the tree is free; else it is busy and stepped
// through. Bodies that are stepped through are assumed to stray by at most kFrameStray from what
// they would do by themselves; if they get farther the frame is made again with all trees busy.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

class FreePaths {
 public:
  // A frame begins, the drives have been aimed at their targets. With `all_busy` no path is looked
  // at.
  void begin(System& system, Data& data, double dt, bool all_busy);
  const std::vector<char>& busy() const { return busy_; }  // per root body
  bool any_busy() const { return any_busy_; }
  bool any_free() const { return any_free_; }
  const std::vector<double>& start() const { return start_qpos_; }  // qpos, of the frame

  // Before the substeps of busy trees: remembers where the free ones are.
  void leave(const State& state) { followed_ = state.pose; }
  // After them: did a busy tree get farther than assumed? Then all trees become busy.
  bool strayed(const System& system);
  void make_all_busy(const Model& m);

  // The same where busy trees have gone no farther than `way` (per shape) [m], about which the broad
  // phase has not been told: a host moves them (hosting.h).
  bool beyond(const System& system, const std::vector<double>& way) const;

  // A person on a free path after a share of the frame, into `q`.
  void along(const Drive& d, double share, double* q) const;
  // After the substeps: people whom nothing touched have arrived, stepped through or not: the same
  // bits either way. `rows`, if any: the frame's n recorded poses, which then follow the path.
  void arrive(System& system, Data& data, double* rows, int n);
  // Tells the broad phase how far the free trees have travelled.
  void travel(System& system, Data& data);

 private:
  void find(System& system, Data& data, double dt);
  void assume_strays(System& system, Data& data, double dt);
  void bound_speeds(const Model& m, const Drive& d);
  double bulge(const Model& m, const CollisionShape& shape) const;
  void sweep(const System& system, const Drive& d, double dt);
  std::vector<Poses>& between(const System& system);
  void count(const Model& m);

  std::vector<char> settled_;  // per person: it is where the motion has it
  std::vector<char> busy_;     // per body
  bool any_busy_ = false, any_free_ = false;
  std::vector<double> start_qpos_, end_qpos_, part_qpos_;
  std::vector<char> follows_;   // per body: its path is looked at
  std::vector<Poses> between_;  // places on the way
  bool between_known_ = false;
  Poses followed_;  // the pose at the start of the frame, for free trees
  Sweep sweep_;
  std::vector<double> assumed_;  // per shape: how far it may have travelled at most [m]
  std::vector<double> angular_;  // per ball joint of a person: bound of its speed [rad/s]
  std::vector<double> spin_, turn_, acceleration_;  // per body: W, B and A
  std::vector<double> rate_;                        // per body: W^2 + B
  std::vector<double> way_;
  std::vector<Twist> twists_;
};

}  // namespace hp
