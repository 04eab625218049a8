// What is known of pairs of shapes, taken over from a world with other shapes.
#include "collision/narrow_phase.h"

namespace hp {

void World::adopt(const World& old, const std::vector<int>& shape) {
  std::vector<int> now(old.shapes.size(), -1);  // the other way round
  for (int i = 0; i < (int)shape.size(); i++)
    if (shape[i] >= 0) now[shape[i]] = i;
  auto known = [&](const ContactCandidate& c) {
    return shape[c.shape] >= 0 && (c.other_shape < 0 || shape[c.other_shape] >= 0);
  };
  auto renamed = [&](auto& c) {
    c.shape = now[c.shape];
    if (c.other_shape >= 0) c.other_shape = now[c.other_shape];
    return c.shape >= 0 && (c.other_static >= 0 || c.other_shape >= 0);
  };
  for (auto it = pairs_.begin(); it != pairs_.end();)
    it = known(unpacked(it->first)) ? pairs_.erase(it) : std::next(it);
  for (const auto& [k, state] : old.pairs_) {
    ContactCandidate c = unpacked(k);
    if (renamed(c)) pairs_[key(c)] = state;
  }
  std::vector<Inside> in;
  for (Inside i : old.inside_)
    if (renamed(i)) in.push_back(i);
  for (const Inside& i : inside_)
    if (shape[i.shape] < 0 || (i.other_shape >= 0 && shape[i.other_shape] < 0)) in.push_back(i);
  inside_ = in;
  growth = old.growth;
  has_list_ = false;
}

}  // namespace hp
