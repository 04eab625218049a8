// Upper bounds of how far a direction separates two convex shapes, from points of theirs.
//
// Along n two shapes are no farther apart than any two of their points: a pair that one direction was
// measured with bounds what another can be worth, without a look at their vertices. Where shapes
// overlap deeply nearly all directions are hopeless so.
#pragma once
#include "geometry/convex.h"
#include "tuning.h"

namespace hp {

class DirectionBounds {
 public:
  DirectionBounds(const PosedShape& a, const PosedShape& b)
      : a_(a), b_(b), round_(a.hull->radius + b.hull->radius) {}
  // Is the distance along n, a unit vector, less than `least` for sure?
  bool under(Vec3 n, double least) const {
    for (int k = 0; k < count_; k++)
      if (dot(n, between_[k]) < least + round_ - tuning::geometry::kBoundRounding) return true;
    return false;
  }
  // The points that are farthest towards each other along n count from now on, in place of the oldest.
  void add(Vec3 n) {
    between_[next_] = a_.support().farthest(-n) - b_.support().farthest(n);
    next_ = (next_ + 1) % tuning::geometry::kBoundPairs;
    if (count_ < tuning::geometry::kBoundPairs) count_++;
  }

 private:
  const PosedShape &a_, &b_;
  const double round_;
  Vec3 between_[tuning::geometry::kBoundPairs];
  int count_ = 0, next_ = 0;
};

}  // namespace hp
