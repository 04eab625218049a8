// What is remembered of pairs of shapes from substep to substep: those that started nearer than the
// clearance or overlapping. All other pairs have no state.
//
// Ordered by pair_key(), so that every loop over them runs in one order on every platform.
#pragma once
#include <cstdint>
#include <map>
#include <vector>

#include "collision/contact_candidate.h"

namespace hp {

struct PairState {
  double clearance =
      0;  // the pair's own, where it started nearer than ContactSettings::clearance [m]
  bool overlapping = false;  // the two overlap and leave along `exit`
  // Unit direction in which the shape leaves; fixed in the world or, of two shapes of one person,
  // in the frame of SelfDepenetration::reference_body().
  Vec3 exit;
  bool kept = false;  // hulls overlap where their surfaces are clear: the overlap may stay
};

class PairStates {
 public:
  // `c`: anything that names a pair (PairId, ContactCandidate).
  template <typename Pair>
  PairState* find(const Pair& c) {
    auto it = states_.find(pair_key(c));
    return it == states_.end() ? nullptr : &it->second;
  }
  // The state of a pair, a new one if there is none.
  template <typename Pair>
  PairState& operator[](const Pair& c) {
    return states_[pair_key(c)];
  }
  PairState& add(const ContactCandidate& c, const PairState& state) {
    return states_.insert({pair_key(c), state}).first->second;
  }
  void erase(const ContactCandidate& c) { states_.erase(pair_key(c)); }
  void clear() { states_.clear(); }
  // Calls each(pair, state) in the order of keys.
  template <typename Each>
  void for_each(Each each) {
    for (auto& [key, state] : states_) each(pair_of_key(key), state);
  }
  template <typename Each>
  void for_each(Each each) const {
    for (const auto& [key, state] : states_) each(pair_of_key(key), state);
  }
  template <typename Which>
  void erase_if(Which which) {
    for (auto it = states_.begin(); it != states_.end();)
      it = which(pair_of_key(it->first)) ? states_.erase(it) : std::next(it);
  }

  void save(std::vector<double>& out) const;
  const double* load(const double* in);

 private:
  std::map<int64_t, PairState> states_;
};

}  // namespace hp
