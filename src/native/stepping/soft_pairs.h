// Which shapes may press which layers, and whether they are near.
//
// A pair is a shape with samples and a static or another shape, one of them soft. Of two shapes a
// person's samples press, else those of the smaller one. Pairs whose shapes belong to one body and that
// have the same other make a group: what they press with is condensed together, so that a thigh of
// three hulls has the rows of one. On a static, fingers belong to the hand (tuning.h, kSmallPart): one that lies on
// a seat has the rows of one body, not of sixteen. Lengths in [m].
#pragma once
#include <vector>

#include "soft/pressing.h"
#include "stepping/system.h"

namespace hp {

struct Data;

class SoftPairs {
 public:
  // Lists the pairs; after the system is finished.
  void finish(const System& system);
  // Everything has been moved.
  void forget();

  int size() const { return (int)all_.size(); }
  SoftPair& operator[](int k) { return all_[k]; }
  const SoftPair& operator[](int k) const { return all_[k]; }
  int groups() const { return groups_; }
  // The first pair of a pair's group.
  int first_of_group(int k) const { return first_[all_[k].group]; }

  // May a point of the shape come within the pair's layers, if they travel `reach` toward each other?
  bool near(const System& system, Data& data, SoftPair& pair, double reach);
  static bool takes_part(const System& system, const SoftPair& pair);
  // How far the two have gone toward each other to the end pose, and since the start of all, at most.
  static double way(const System& system, Data& data, const SoftPair& pair);
  static double travelled(const System& system, const SoftPair& pair);

 private:
  void list(const System& system, int shape, int other_static, int other_shape);
  void find_groups(const System& system);

  std::vector<SoftPair> all_;
  std::vector<int> first_;  // per group
  int groups_ = 0;
};

}  // namespace hp
