#include "collision/obstacle.h"

#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

namespace {

// A straight line as a shape of two points.
struct Segment {
  Convex hull;
  PosedShape posed;
  Segment(Vec3 a, Vec3 b) {
    hull.vertices = {a, b};
    hull.finish();
    posed.place(hull, {}, {});
  }
};

}  // namespace

Obstacle Obstacle::of_static(const CollisionWorld& world, int other_static) {
  Obstacle o;
  o.other_static = other_static;
  o.fixed = &world.statics[other_static];
  o.name = o.fixed->name;
  return o;
}

Obstacle Obstacle::of_shape(const CollisionWorld& world, Poses& start, int other_shape) {
  Obstacle o;
  o.other_shape = other_shape;
  o.object = &world.place(start, other_shape);
  o.name = world.shapes[other_shape].name;
  return o;
}

bool Obstacle::meets(const Box3& box) const {
  if (is(Static::Kind::Mesh)) return box.meets(fixed->tree->box());
  return is(Static::Kind::HalfSpace) || box.meets(posed().box());
}

bool Obstacle::clear(const PosedShape& a, double range, size_t& tests) const {
  if (is(Static::Kind::HalfSpace)) return a.lowest(fixed->n) - fixed->offset >= range;
  if (is(Static::Kind::Mesh)) return !fixed->tree->nearer(a, range, tests);
  tests += tuning::geometry::kMeasureTests;
  return separate(a, posed(), 2 * range, false).dist >= range;
}

bool Obstacle::crosses(Vec3 a, Vec3 b, size_t& tests) const {
  if (is(Static::Kind::HalfSpace))
    return std::min(dot(fixed->n, a), dot(fixed->n, b)) <= fixed->offset;
  return !clear(Segment(a, b).posed, tune::kRestingOverlap, tests);
}

}  // namespace hp
