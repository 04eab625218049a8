// The samples of a group that are under pressure, four in a block: loops over them take several at a time.
#pragma once
#include <vector>

#include "math/lanes.h"
#include "math/vec.h"

namespace hp {

struct PressedBlock {
  static constexpr int kSize = 4;
  double x[3][kSize] = {}, n[3][kSize] = {};  // where an impulse acts [m], and along what
  double load[kSize] = {};                    // [N]
  double impulse[kSize] = {};                 // q_i [N s]
  double yield[kSize] = {};                   // S_i [kg]
  double patch[kSize] = {-1, -1, -1, -1};     // a whole number; -1: none yet, or no sample
  int sample[kSize] = {};                     // of the shape
  int member[kSize] = {};                     // the caller's number of its pair

  Vec3 place(int k) const { return {x[0][k], x[1][k], x[2][k]}; }
  Vec3 normal(int k) const { return {n[0][k], n[1][k], n[2][k]}; }
};

class PressedSamples {
 public:
  void clear() { blocks_.clear(), size_ = 0; }
  bool empty() const { return size_ == 0; }
  // Makes room for one more, which is the k-th of the block.
  PressedBlock& add(int& k) {
    k = size_++ % PressedBlock::kSize;
    if (k == 0) blocks_.emplace_back();
    return blocks_.back();
  }
  std::vector<PressedBlock>& blocks() { return blocks_; }
  const std::vector<PressedBlock>& blocks() const { return blocks_; }

 private:
  std::vector<PressedBlock> blocks_;
  int size_ = 0;
};

// A sum over samples, in four parts, of those that are first in their blocks, second, ...: the same for any number
// of lanes.
struct FourSums {
  double of[PressedBlock::kSize] = {};
  HP_INLINE void add(int k, const Lanes& x) { lanes(of + k) += x; }
  double total() const { return (of[0] + of[1]) + (of[2] + of[3]); }
};
struct FourSums3 {
  FourSums of[3];
  Vec3 total() const { return {of[0].total(), of[1].total(), of[2].total()}; }
};

}  // namespace hp
