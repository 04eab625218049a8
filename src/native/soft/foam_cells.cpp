#include "soft/foam_cells.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "math/elementary.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

void FoamCells::clear() {
  table_.clear(), moves_++;
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

size_t FoamCells::find(const FoamCell& k) const {
  size_t at = home(k);
  while (table_[at].used && !(table_[at].key == k)) at = (at + 1) & (table_.size() - 1);
  return at;
}

const FoamCells::Cell& FoamCells::look_for(FoamPlace& place) const {
  place.found = (int)find(place.cell), place.moves = moves_;
  return table_[place.found];
}

double FoamCells::faded(const Cell& c, double recovery) const {
  return c.gone * elementary::exp(-(time_ - c.time) / recovery);
}

void FoamCells::grow() {
  std::vector<Cell> old(std::max<size_t>(64, 2 * table_.size()));
  std::swap(old, table_);
  moves_++;
  for (const Cell& c : old)
    if (c.used) table_[find(c.key)] = c;
}

// Cells behind the free place that belong there or before it move up.
void FoamCells::erase(const FoamCell& k) {
  const size_t mask = table_.size() - 1;
  size_t hole = find(k);
  if (!table_[hole].used) return;
  moves_++;
  for (size_t at = (hole + 1) & mask; table_[at].used; at = (at + 1) & mask) {
    const size_t way = (at - home(table_[at].key)) & mask;
    if (way < ((at - hole) & mask)) continue;
    table_[hole] = table_[at];
    hole = at;
  }
  table_[hole] = {};
  used_--;
}

void FoamCells::end_step(double h) {
  time_ += h;
  size_t forgotten = 0;
  for (FoamPlace& p : pressed_) {
    find(p);
    Cell& c = table_[p.found];
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
    FoamPlace place{{(int)in[0], (int)in[1], (int)in[2], (int)in[3]}};
    Cell& c = cell(place);
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
    FoamPlace place{k};
    Cell& c = cell(place);
    c = its, c.key = k;
  }
}

}  // namespace hp
