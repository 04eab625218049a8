// What foam remembers: how far the dashpots of its Maxwell arms have gone (soft_law.h), per cell of the layer.
//
// Cells are cubes of a grid in the frame of the layer's thing, filed by the nearest point of its hard frame: so it is
// the sofa that remembers, not who sat there. A cell that is not pressed goes back by
// q(t) = q exp(-t/(tau (1 + r))), found when it is asked for.
//
// A table with open addresses; `hint` is where a cell was found last, which saves looking for it.
#pragma once
#include <array>
#include <vector>

#include "math/vec.h"
#include "soft/soft_law.h"

namespace hp {

class FoamCells {
 public:
  void clear();
  // q [m] of the layer's cell around `at` (the layer's frame).
  double gone(int layer, Vec3 at, const SoftLaw& law, int& hint) const;
  // In this step the arm there has come to q, over that much area [m^2].
  void press(int layer, Vec3 at, double q, double area, int hint);
  // The step is over: h [s] have passed, and cells have the mean of what was pressed in them.
  void end_step(double h);

  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // The memory of others, whose shapes have the numbers `now` here (-1: gone).
  void adopt(const FoamCells& old, const std::vector<int>& now);

 private:
  using Key = std::array<int, 4>;  // layer (pressing.h, FoamPlace), cell
  struct Cell {
    Key key{};
    bool used = false;
    double gone = 0, time = 0;  // q, at this time
    double sum = 0, area = 0;   // of the step
  };
  static Key key(int layer, Vec3 at);
  size_t home(const Key& k) const;
  // The cell's place, or the free one where it would be.
  size_t find(const Key& k, int hint) const;
  Cell& cell(const Key& k, int hint);
  void grow();
  void erase(const Key& k);

  std::vector<Cell> table_;  // a power of two, at most half of it used
  size_t used_ = 0;
  std::vector<Key> pressed_;
  double time_ = 0;
};

}  // namespace hp
