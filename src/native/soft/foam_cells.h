// What foam remembers: how far the dashpots of its Maxwell arms have gone (soft_law.h), per cell of the layer.
//
// Cells are cubes of a grid in the frame of the layer's thing, filed by the nearest point of its hard frame: so it is
// the sofa that remembers, not who sat there. A cell that is not pressed goes back by
// q(t) = q exp(-t/(tau (1 + r))), found when it is asked for.
//
// A table with open addresses. A place keeps the number of its cell and where that was found last: it is there still
// until cells move.
#pragma once
#include <cstdint>
#include <tuple>
#include <vector>

#include "math/vec.h"
#include "soft/soft_law.h"
#include "tuning.h"

namespace hp {

struct FoamCell {
  int layer = 0, x = 0, y = 0, z = 0;  // layer: pressing.h, FoamFrame
  // The one of the layer around `at` (the layer's frame).
  static FoamCell around(int layer, Vec3 at) {
    return {layer, number(at.x), number(at.y), number(at.z)};
  }
  bool operator==(const FoamCell& o) const {
    return x == o.x && y == o.y && z == o.z && layer == o.layer;
  }
  bool operator<(const FoamCell& o) const {
    return std::tie(layer, x, y, z) < std::tie(o.layer, o.x, o.y, o.z);
  }

 private:
  static int number(double x) {
    const double cells = x * tuning::soft::kFoamCells + tuning::soft::kCellShift;
    const double cell = cells < kFarthest ? (cells > -kFarthest ? cells : -kFarthest) : kFarthest;
    const int down = (int)cell;
    return down - (cell < down);
  }
  static constexpr double kFarthest = 1e9;
};
struct FoamPlace {
  FoamCell cell;
  int found = -1;      // in the table, or where it would be
  uint64_t moves = 0;  // how often cells had moved then; 0: it has not been looked for
  void lie_in(const FoamCell& k) {
    if (!(cell == k)) cell = k, moves = 0;
  }
};

class FoamCells {
 public:
  void clear();
  // q [m] of the cell, which goes back with this time constant [s].
  double gone(double recovery, FoamPlace& place) const {
    if (used_ == 0) return 0;
    const Cell& c = find(place);
    if (!c.used) return 0;
    return time_ > c.time ? faded(c, recovery) : c.gone;
  }
  // In this step the arm there has come to q, over that much area [m^2].
  void press(double q, double area, FoamPlace& place) {
    Cell& c = cell(place);
    if (c.area == 0) pressed_.push_back(place), c.sum = 0;
    c.sum += area * q;
    c.area += area;
  }
  // The step is over: h [s] have passed, and cells have the mean of what was pressed in them.
  void end_step(double h);

  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // The memory of others, whose shapes have the numbers `now` here (-1: gone).
  void adopt(const FoamCells& old, const std::vector<int>& now);

 private:
  struct Cell {
    FoamCell key;
    bool used = false;
    double gone = 0, time = 0;  // q, at this time
    double sum = 0, area = 0;   // of the step
  };
  size_t home(const FoamCell& k) const;
  // Where the cell is, or the free place where it would be.
  size_t find(const FoamCell& k) const;
  // What was found free may have been given to another cell since.
  const Cell& find(FoamPlace& place) const {
    if (place.moves == moves_) {
      const Cell& c = table_[place.found];
      if (!c.used || c.key == place.cell) return c;
    }
    return look_for(place);
  }
  const Cell& look_for(FoamPlace& place) const;
  double faded(const Cell& c, double recovery) const;
  Cell& cell(FoamPlace& place) {
    if (2 * (used_ + 1) > table_.size()) grow();
    find(place);
    Cell& c = table_[place.found];
    if (!c.used) c.used = true, c.key = place.cell, used_++;
    return c;
  }
  void grow();
  void erase(const FoamCell& k);

  std::vector<Cell> table_;  // a power of two, at most half of it used
  size_t used_ = 0;
  uint64_t moves_ = 1;  // counts when cells of the table move
  std::vector<FoamPlace> pressed_;
  double time_ = 0;
};

}  // namespace hp
