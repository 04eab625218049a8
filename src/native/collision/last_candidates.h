// The candidates of the last query at a pose, for the next one at the same pose.
//
// A query is repeated where a shape turns out to move farther than was asked, or a step is tried
// again. Pairs of shapes that are asked for as far as the last time then have the same candidates, to
// the bit: measured again they could differ by a rounding, because a measurement starts from the one
// before it. So no body feels that another is asked for again.
#pragma once
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "collision/broad_phase.h"

namespace hp {

class LastCandidates {
 public:
  void forget() { stamp_ = 0; }
  // A query at a pose, in a substep of h [s], for everything within valid[shape] [m]: sets `valid` of
  // shapes that are asked for as far as the last time to how far their candidates held then.
  void begin(uint64_t stamp, double h, std::vector<double>& valid);
  // The candidates of this shape are to be found again.
  void renew(int shape) { same_[shape] = 0; }
  // Appends the candidates that the pair had, if they hold; false: it is to be measured.
  bool repeat(BroadPhasePair& e, std::vector<ContactCandidate>& out);
  // The candidate at `index` of the last query, the only one of its pair, has been measured since.
  void replace(size_t index, const ContactCandidate& c);
  void end(const std::vector<double>& valid, const std::vector<ContactCandidate>& all);

 private:
  uint64_t stamp_ = 0;  // of the pose; 0: none
  double h_ = 0;
  bool again_ = false;
  uint64_t query_ = 0;  // number of this query
  std::vector<char> same_;
  std::vector<double> asked_, valid_;  // per shape [m]
  std::vector<ContactCandidate> candidates_;
  std::unordered_map<int64_t, size_t> first_;  // the first candidate of a pair, by pair_key
};

}  // namespace hp
