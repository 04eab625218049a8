#include "collision/last_candidates.h"

namespace hp {

void LastCandidates::begin(uint64_t stamp, double h, std::vector<double>& valid) {
  again_ = stamp_ == stamp && h_ == h && asked_.size() == valid.size();
  stamp_ = stamp, h_ = h;
  query_++;
  asked_.resize(valid.size());
  same_.assign(valid.size(), 0);
  for (size_t i = 0; i < valid.size(); i++) {
    same_[i] = again_ && asked_[i] == valid[i];
    asked_[i] = valid[i];
    if (same_[i]) valid[i] = valid_[i];
  }
  first_.clear();
  for (size_t i = 0; i < candidates_.size() && again_; i++)
    first_.insert({pair_key(candidates_[i]), i});
}

bool LastCandidates::repeat(BroadPhasePair& e, std::vector<ContactCandidate>& out) {
  const bool known = again_ && e.query + 1 == query_;  // it took part in the last query
  e.query = query_;
  if (!known || !same_[e.shape] || (e.other_shape >= 0 && !same_[e.other_shape])) return false;
  const auto found = first_.find(pair_key(e));
  if (found == first_.end()) return true;
  for (size_t i = found->second; i < candidates_.size(); i++) {
    if (pair_key(candidates_[i]) != found->first) break;
    out.push_back(candidates_[i]);
  }
  return true;
}

void LastCandidates::replace(size_t index, const ContactCandidate& c) { candidates_[index] = c; }

void LastCandidates::end(const std::vector<double>& valid,
                         const std::vector<ContactCandidate>& all) {
  valid_ = valid;
  candidates_ = all;
}

}  // namespace hp
