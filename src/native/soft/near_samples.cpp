#include "soft/near_samples.h"

#include <algorithm>

#include "math/lanes.h"

namespace hp {

namespace {

constexpr size_t kRoom = 8;  // of the first samples of a pair: whole lanes

template <typename T>
void keep_of(const std::vector<int>& places, std::vector<T>& all) {
  std::vector<T> kept;
  kept.reserve(places.size());
  for (const int i : places) kept.push_back(all[i]);
  all.swap(kept);
}

}  // namespace

void NearSamples::clear() { keep({}); }

SoftLaw NearSamples::law(int i) const {
  const NearSamples& all = *this;
  return {all[Stiffness][i], all[Damping][i], all[Densification][i], all[Arm][i],
          all[Relaxation][i]};
}

void NearSamples::set_law(int i, const SoftLaw& law) {
  NearSamples& all = *this;
  all[Stiffness][i] = law.stiffness, all[Damping][i] = law.damping;
  all[Densification][i] = law.densification;
  all[Arm][i] = law.arm, all[Relaxation][i] = law.relaxation;
}

void NearSamples::end(Column c) {
  double* of = (*this)[c];
  for (size_t i = sample.size(); i < room_ && i % kLanes != 0; i++) of[i] = 0;
}

int NearSamples::add(int number) {
  const size_t n = sample.size();
  if (n == room_) {
    const size_t room = std::max(kRoom, 2 * room_);
    spare_.assign(room * Columns, 0);
    for (int c = 0; c < Columns; c++)
      std::copy_n(numbers_.data() + c * room_, n, spare_.data() + c * room);
    numbers_.swap(spare_);
    room_ = room;
  }
  for (int c = 0; c < Columns; c++) numbers_[c * room_ + n] = 0;
  sample.push_back(number), triangle.push_back(-1);
  measured.push_back(0), celled.push_back(0), cell.push_back({});
  return (int)n;
}

void NearSamples::keep(const std::vector<int>& places) {
  spare_.resize(numbers_.size());
  for (int c = 0; c < Columns; c++) {
    const double* from = numbers_.data() + c * room_;
    double* to = spare_.data() + c * room_;
    for (const int i : places) *to++ = from[i];
  }
  numbers_.swap(spare_);
  keep_of(places, sample), keep_of(places, triangle);
  keep_of(places, measured), keep_of(places, celled), keep_of(places, cell);
}

}  // namespace hp
