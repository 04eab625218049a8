// The contact cache: impulses of the last substep, from which the solver starts (warm start, as in
// Jolt's ContactConstraintManager and Bullet's persistent manifolds).
//
// A contact is found again by its pair of shapes, a normal within acos(0.8) of the old one, and a
// place within 2 cm of where its material point is now. Each cached impulse is used once per
// attempt. A substep in pieces writes the cache island by island: keep() collects what the substep
// leaves for the next one.
#pragma once
#include <algorithm>
#include <vector>

#include "stepping/system.h"

namespace hp {

struct State;

class ContactCache {
 public:
  const std::vector<CachedContact>& contacts() const { return contacts_; }
  std::vector<CachedContact>& contacts() { return contacts_; }
  void clear() { contacts_.clear(); }
  void restore(const std::vector<CachedContact>& contacts) { contacts_ = contacts; }
  // An attempt at a step begins: no impulse is used yet.
  void begin_attempt();
  // Gives a new contact the impulse [N s] that is remembered of it; false if there is none.
  bool warm_start(const System& system, State& state,
                  const std::vector<ContactCandidate>& candidates, Contact& c);
  // Forgets impulses between trees that `forget` (per root body) marks.
  void forget(const System& system, const std::vector<char>& forget);

  void begin_substep() { next_.clear(); }
  // What an earlier piece of the substep left of trees (per root body) that are `renewed` is out of date.
  void drop(const System& system, const std::vector<char>& renewed);
  // Keeps a contact for the next substep: one that carries an impulse, or a vertex near a static.
  void keep(const System& system, State& state, const ContactCandidate& candidate,
            const Contact& c);
  void end_substep() { contacts_.swap(next_); }

  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // Of a cache of other shapes, what concerns shapes that are still there; `now`: per old shape its
  // new index, -1: it is gone.
  void adopt(const ContactCache& old, const std::vector<int>& now);

 private:
  std::vector<CachedContact> contacts_, next_;
};

}  // namespace hp
