#include "soft/foam_cells.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "math/elementary.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

void FoamCells::clear() {
  table_.clear();
  used_ = 0;
  pressed_.clear();
  time_ = 0;
}

size_t FoamCells::home(const FoamCell& k) const {
  uint64_t sum = 0;
  for (const int i : {k.layer, k.x, k.y, k.z})
    sum = (sum ^ (uint32_t)i) * 0x9e3779b97f4a7c15u, sum ^= sum >> 29;
  return (size_t)sum & (table_.size() - 1);
}

size_t FoamCells::find(const FoamCell& k, int hint) const {
  if (hint >= 0 && (size_t)hint < table_.size() && table_[hint].used && table_[hint].key == k)
    return hint;
  size_t at = home(k);
  while (table_[at].used && !(table_[at].key == k)) at = (at + 1) & (table_.size() - 1);
  return at;
}

void FoamCells::grow() {
  std::vector<Cell> old(std::max<size_t>(64, 2 * table_.size()));
  std::swap(old, table_);
  for (const Cell& c : old)
    if (c.used) table_[find(c.key, -1)] = c;
}

FoamCells::Cell& FoamCells::cell(const FoamCell& k, int hint) {
  if (2 * (used_ + 1) > table_.size()) grow();
  Cell& c = table_[find(k, hint)];
  if (!c.used) c.used = true, c.key = k, used_++;
  return c;
}

// Cells behind the free place that belong there or before it move up.
void FoamCells::erase(const FoamCell& k) {
  const size_t mask = table_.size() - 1;
  size_t hole = find(k, -1);
  if (!table_[hole].used) return;
  for (size_t at = (hole + 1) & mask; table_[at].used; at = (at + 1) & mask) {
    const size_t way = (at - home(table_[at].key)) & mask;
    if (way < ((at - hole) & mask)) continue;
    table_[hole] = table_[at];
    hole = at;
  }
  table_[hole] = {};
  used_--;
}

double FoamCells::gone(double recovery, FoamPlace& place) const {
  if (used_ == 0) return 0;
  place.found = (int)find(place.cell, place.found);
  const Cell& c = table_[place.found];
  if (!c.used) return 0;
  const double since = time_ - c.time;
  if (since <= 0) return c.gone;
  return c.gone * elementary::exp(-since / recovery);
}

void FoamCells::press(double q, double area, FoamPlace& place) {
  Cell& c = cell(place.cell, place.found);
  place.found = (int)(&c - table_.data());
  if (c.area == 0) pressed_.push_back(place), c.sum = 0;
  c.sum += area * q;
  c.area += area;
}

void FoamCells::end_step(double h) {
  time_ += h;
  size_t forgotten = 0;
  for (const FoamPlace& p : pressed_) {
    Cell& c = table_[find(p.cell, p.found)];
    c.gone = c.sum / c.area;
    c.time = time_;
    c.sum = c.area = 0;
    if (std::fabs(c.gone) < tune::kForgotten) pressed_[forgotten++] = p;
  }
  for (size_t i = 0; i < forgotten; i++) erase(pressed_[i].cell);
  pressed_.clear();
}

void FoamCells::save(std::vector<double>& out) const {
  std::vector<const Cell*> all;
  for (const Cell& c : table_)
    if (c.used) all.push_back(&c);
  std::sort(all.begin(), all.end(), [](const Cell* a, const Cell* b) { return a->key < b->key; });
  out.insert(out.end(), {time_, (double)all.size()});
  for (const Cell* c : all) {
    const FoamCell& k = c->key;
    out.insert(out.end(),
               {(double)k.layer, (double)k.x, (double)k.y, (double)k.z, c->gone, c->time});
  }
}

const double* FoamCells::load(const double* in) {
  clear();
  time_ = *in++;
  for (int n = (int)*in++; n > 0; n--, in += 6) {
    Cell& c = cell({(int)in[0], (int)in[1], (int)in[2], (int)in[3]}, -1);
    c.gone = in[4], c.time = in[5];
  }
  return in;
}

void FoamCells::adopt(const FoamCells& old, const std::vector<int>& now) {
  clear();
  time_ = old.time_;
  for (const Cell& its : old.table_) {
    FoamCell k = its.key;
    if (!its.used || (k.layer < 0 && now[-k.layer - 1] < 0)) continue;
    if (k.layer < 0) k.layer = -now[-k.layer - 1] - 1;
    Cell& c = cell(k, -1);
    c = its, c.key = k;
  }
}

}  // namespace hp
