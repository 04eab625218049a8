#include "collision/pair_states.h"

namespace hp {

void PairStates::save(std::vector<double>& out) const {
  out.push_back((double)states_.size());
  for (const auto& [k, s] : states_)
    out.insert(out.end(),
               {(double)(k >> 32), (double)(k & 0xffffffff), s.clearance, s.overlapping ? 1.0 : 0.0,
                s.exit.x, s.exit.y, s.exit.z, s.kept ? 1.0 : 0.0});
}

const double* PairStates::load(const double* in) {
  states_.clear();
  for (int n = (int)*in++; n > 0; n--, in += 8)
    states_[((int64_t)in[0] << 32) | (int64_t)in[1]] = {in[2], in[3] != 0, load3(in + 4),
                                                        in[7] != 0};
  return in;
}

}  // namespace hp
