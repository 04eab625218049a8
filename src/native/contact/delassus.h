// The Delassus operator A = J M^-1 J^T [1/kg] of the contacts that take part, dense, 3 x 3 by contact.
//
// It grows by the contacts that join, and never has room for more than half as many again: most
// contacts of a step carry nothing and never join. What is not written has no meaning.
#pragma once
#include <algorithm>
#include <cstring>
#include <vector>

#include "tuning.h"

namespace hp {

class Delassus {
 public:
  void clear() { stride_ = 0; }
  // The 3 x 3 block of contacts i and j; its rows are `stride` numbers apart.
  double* block(int i, int j) { return &entries_[(size_t)(3 * i) * stride_ + 3 * j]; }
  const double* block(int i, int j) const { return &entries_[(size_t)(3 * i) * stride_ + 3 * j]; }
  const double* row(int i) const { return &entries_[(size_t)i * stride_]; }
  size_t stride() const { return stride_; }
  // Room for `contacts`, the first `used` of which are there already: their blocks move.
  void reserve(int contacts, int used) {
    if (3 * (size_t)contacts <= stride_) return;
    const size_t old = stride_, n = 3 * (size_t)used;
    stride_ = 3 * (size_t)std::max(contacts + contacts / 2, tuning::contact::kFirstCapacity);
    if (entries_.size() < stride_ * stride_) entries_.resize(stride_ * stride_);
    // From the last row to the first, each to where no other still stands.
    for (size_t i = n; i-- > 1;)
      std::memmove(&entries_[i * stride_], &entries_[i * old], n * sizeof(double));
  }

 private:
  size_t stride_ = 0;
  std::vector<double> entries_;
};

}  // namespace hp
