#include "soft/foam_cells.h"

#include <algorithm>
#include <cmath>

#include "math/elementary.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

void FoamCells::clear() {
  cells_.clear();
  pressed_.clear();
  time_ = 0;
}

FoamCells::Key FoamCells::key(int layer, Vec3 at) {
  Key out{layer, 0, 0, 0};
  for (int i = 0; i < 3; i++) {
    const double cell = std::floor(at[i] / tune::kFoamCell + tune::kCellShift);
    out[i + 1] = (int)std::fmax(-1e9, std::fmin(cell, 1e9));
  }
  return out;
}

size_t FoamCells::Hash::operator()(const Key& k) const {
  uint64_t sum = 0;
  for (const int i : k) sum = (sum ^ (uint32_t)i) * 0x9e3779b97f4a7c15u, sum ^= sum >> 29;
  return (size_t)sum;
}

double FoamCells::gone(int layer, Vec3 at, const SoftLaw& law) const {
  const auto found = cells_.find(key(layer, at));
  if (found == cells_.end()) return 0;
  const double since = time_ - found->second.time;
  if (since <= 0) return found->second.gone;
  return found->second.gone * elementary::exp(-since / (law.relaxation * (1 + law.arm)));
}

void FoamCells::press(int layer, Vec3 at, double q, double area) {
  const Key k = key(layer, at);
  Cell& cell = cells_[k];
  if (cell.area == 0) pressed_.push_back(k), cell.sum = 0;
  cell.sum += area * q;
  cell.area += area;
}

void FoamCells::end_step(double h) {
  time_ += h;
  for (const Key& k : pressed_) {
    const auto found = cells_.find(k);
    Cell& cell = found->second;
    cell.gone = cell.sum / cell.area;
    cell.time = time_;
    cell.sum = cell.area = 0;
    if (std::fabs(cell.gone) < tune::kForgotten) cells_.erase(found);
  }
  pressed_.clear();
}

void FoamCells::save(std::vector<double>& out) const {
  out.insert(out.end(), {time_, (double)cells_.size()});
  std::vector<Key> keys;
  for (const auto& entry : cells_) keys.push_back(entry.first);
  std::sort(keys.begin(), keys.end());
  for (const Key& k : keys) {
    for (const int i : k) out.push_back(i);
    const Cell& cell = cells_.at(k);
    out.insert(out.end(), {cell.gone, cell.time});
  }
}

const double* FoamCells::load(const double* in) {
  clear();
  time_ = *in++;
  for (int n = (int)*in++; n > 0; n--, in += 6) {
    Cell& cell = cells_[{(int)in[0], (int)in[1], (int)in[2], (int)in[3]}];
    cell.gone = in[4], cell.time = in[5];
  }
  return in;
}

void FoamCells::adopt(const FoamCells& old, const std::vector<int>& now) {
  clear();
  time_ = old.time_;
  for (const auto& [key, cell] : old.cells_) {
    Key k = key;
    if (k[0] < 0 && now[-k[0] - 1] < 0) continue;
    if (k[0] < 0) k[0] = -now[-k[0] - 1] - 1;
    cells_[k] = cell;
  }
}

}  // namespace hp
