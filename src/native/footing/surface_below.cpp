#include "footing/surface_below.h"

#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

SurfaceBelow::SurfaceBelow(const CollisionWorld& world, const char* own) : world_(world) {
  point_.vertices = {{}};
  point_.finish();
  for (int i = 0; i < (int)world_.shapes.size(); i++)
    if (world_.shapes[i].person < 0 && !(own && own[world_.shapes[i].body]) &&
        !passes(own, world_.shapes[i].name))
      objects_.push_back(i);
  for (const Static& s : world_.statics) ghost_.push_back(passes(own, s.name));
}

// Does every part of the person ignore what has this name?
bool SurfaceBelow::passes(const char* own, int name) const {
  bool any = false;
  for (const CollisionShape& part : world_.shapes) {
    if (!own || part.person < 0 || !own[part.body]) continue;
    if (!world_.pairing(part.name, name).ignore) return false;
    any = true;
  }
  return any;
}

// Falls towards the shape: a step to the plane that separates it, again and again. Exact for a face
// after one.
void SurfaceBelow::meet(const PosedShape& shape, int number, double layer, Vec3 x, double above,
                        Surface& best) {
  const Box3& box = shape.box();
  if (x.x < box.lo.x || x.x > box.hi.x || x.y < box.lo.y || x.y > box.hi.y) return;
  if (box.hi.z + layer / tune::kSteep <= best.top() || box.lo.z > x.z + above) return;
  Vec3 at = x;
  at.z = x.z + above;
  if (box.hi.z < at.z) at.z = box.hi.z + tune::kAboveBox;
  double steepness = 0;  // of the last plane
  for (int i = 0; i < tune::kFallSteps; i++) {
    probe_.place(point_, {}, at);
    const Separation s = separate(probe_, shape, 1e300, false);
    if (s.dist <= tune::kLanded) {
      if (i == 0) return;  // it began inside: a wall, or what is too high to step on
      break;
    }
    if (s.n.z <= 0) return;  // it falls past
    steepness = s.n.z;
    at.z -= s.dist / s.n.z;
    if (at.z + layer / s.n.z < best.top()) return;
  }
  if (steepness < tune::kSteep) return;
  best = {at.z, number, layer / steepness, true};
}

Surface SurfaceBelow::find_static(Vec3 x, double step, double depth) {
  Surface best{x.z - depth, -1, 0, false};
  for (size_t k = 0; k < world_.statics.size(); k++) {
    const Static& s = world_.statics[k];
    if (ghost_[k]) continue;
    if (s.kind == Static::Kind::HalfSpace) {
      if (s.n.z < tune::kSteep) continue;
      const double z = (s.offset - s.n.x * x.x - s.n.y * x.y) / s.n.z;
      if (z + s.layer / s.n.z > best.top()) best = {z, -1, s.layer / s.n.z, true};
    } else if (s.kind == Static::Kind::Hull) {
      meet(s.posed, -1, s.layer, x, step, best);
    } else {
      const double z = s.tree->below({x.x, x.y, x.z + step}, tune::kSteep);
      if (z + s.layer > best.top()) best = {z, -1, s.layer, true};
    }
  }
  return best;
}

Surface SurfaceBelow::find(Poses& poses, Vec3 x, double step, double depth) {
  Surface best = find_static(x, step, depth);
  for (int i : objects_) {
    const BoundingSphere& ball = poses.cached_bounding_sphere(world_.shapes, i);
    const double dx = ball.center.x - x.x, dy = ball.center.y - x.y;
    if (dx * dx + dy * dy > ball.radius * ball.radius) continue;
    meet(world_.place(poses, i), i, world_.shapes[i].layer, x, tune::kOnObject, best);
  }
  return best;
}

// Does static geometry go on at this height around a point of it?
bool SurfaceBelow::wide(Vec3 x, double height) {
  int found = 0;
  for (int i = 0; i < tune::kAround; i++) {
    const double angle = 2 * M_PI * i / tune::kAround;
    const Vec3 beside{x.x + tune::kFootWidth * elementary::cos(angle),
                      x.y + tune::kFootWidth * elementary::sin(angle), height};
    found += find_static(beside, tune::kSameLevel, tune::kSameLevel).found;
  }
  return found >= tune::kAroundFound;
}

// Looks past what is too narrow; `find` finds the surface that is at most so far above.
template <class Find>
Surface SurfaceBelow::past_narrow(Vec3 x, double step, const Find& find) {
  Surface s = find(step);
  for (int i = 0; i < tune::kNarrowThings; i++) {
    if (!s.found || s.shape >= 0 || s.height < x.z + tune::kStepsOver || wide(x, s.height)) break;
    s = find(s.height - x.z - tune::kUnderIt);
  }
  return s;
}

Surface SurfaceBelow::find_footing(Poses& poses, Vec3 x, double step, double depth) {
  return past_narrow(x, step, [&](double up) { return find(poses, x, up, depth); });
}

Surface SurfaceBelow::find_static_footing(Vec3 x, double step, double depth) {
  return past_narrow(x, step, [&](double up) { return find_static(x, up, depth); });
}

}  // namespace hp
