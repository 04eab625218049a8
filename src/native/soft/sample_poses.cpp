#include "soft/sample_poses.h"

#include "math/lanes.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

namespace {

SamplePoses::Carrying carrying(const Mat3& R, Vec3 shift) {
  SamplePoses::Carrying c;
  for (int k = 0; k < 3; k++) {
    store3(c.column[k], R.col(k));
    c.column[k][3] = 0;
  }
  store3(c.shift, shift);
  c.shift[3] = 0;
  return c;
}

HP_INLINE void blend(const SurfaceSamples& samples, const SamplePoses::Carrying* by, int sample,
                     const Vec3& rest, bool turned_only, double* out) {
  const int first = samples.first_carrier[sample], end = samples.first_carrier[sample + 1];
  for (int k = 0; k < 4; k += kLanes) {
    Lanes sum = {};
    for (int e = first; e < end; e++) {
      const SurfaceSamples::Carrier& c = samples.carriers[e];
      const SamplePoses::Carrying& its = by[c.influence];
      const Lanes turned = rest.x * lanes(its.column[0] + k) + rest.y * lanes(its.column[1] + k) +
                           rest.z * lanes(its.column[2] + k);
      sum += c.weight * (turned_only ? turned : lanes(its.shift + k) + turned);
    }
    lanes(out + k) = sum;
  }
}

}  // namespace

// Of n samples, each a row of four numbers.
HP_CLONES void blend_points(const SurfaceSamples& samples, const SamplePoses::Carrying* by,
                            const int* sample, int n, double* out) {
  for (int i = 0; i < n; i++, out += 4)
    blend(samples, by, sample[i], samples.points[sample[i]], false, out);
}

HP_CLONES void blend_normals(const SurfaceSamples& samples, const SamplePoses::Carrying* by,
                             const int* sample, int n, double* out) {
  for (int i = 0; i < n; i++, out += 4)
    blend(samples, by, sample[i], samples.normals[sample[i]], true, out);
}

SamplePoses::SamplePoses(const CollisionWorld& world, const SoftWorld& soft, Poses& pose, int shape)
    : samples_(soft.samples_of(shape)), shape_(world.shapes[shape]), pose_(pose) {
  if (!shape_.skin) return;
  const std::vector<CollisionShape::Influence>& all = shape_.influences;
  if (pose.fresh[shape] || !shape_.blend_bounds.empty() || all.size() > kMostInfluences)
    points_ = world.place(pose, shape).points();
  for (size_t k = 0; k < all.size() && k < kMostInfluences; k++) {
    const Mat3& R = pose.kin.xmat[all[k].body];
    // The joint's position at rest is the shape's centre minus where the joint carries that.
    carrying_[k] =
        carrying(R, pose.kin.xpos[all[k].body] - R * (shape_.hull.center - all[k].center));
  }
}

Vec3 SamplePoses::position(int sample) const {
  const Vec3& rest = samples_.points[sample];
  if (!shape_.skin) return pose_.kin.xpos[shape_.body] + pose_.kin.xmat[shape_.body] * rest;
  if (points_.n > 0) return points_.at(samples_.vertex[sample]);
  double x[4];
  blend_points(samples_, carrying_, &sample, 1, x);
  return load3(x);
}

// By the body that carries most of the shape.
Vec3 SamplePoses::normal(int sample) const {
  return pose_.kin.xmat[shape_.body] * samples_.normals[sample];
}

void SamplePoses::put_points(NearSamples& near) const {
  using N = NearSamples;
  const int n = near.size();
  if (!shape_.skin || points_.n > 0) {
    for (int i = 0; i < n; i++) near.set(N::Hard, i, position(near.sample[i]));
    return;
  }
  double* rows = near.rows();
  blend_points(samples_, carrying_, near.sample.data(), n, rows);
  for (int i = 0; i < n; i++) near.set(N::Hard, i, load3(rows + 4 * (size_t)i));
}

void SamplePoses::put_normals(NearSamples& near) const {
  using N = NearSamples;
  const int n = near.size();
  if (!shape_.skin || shape_.influences.size() > kMostInfluences) {
    for (int i = 0; i < n; i++) near.set(N::Normal, i, normal(near.sample[i]));
    return;
  }
  double* rows = near.rows();
  blend_normals(samples_, carrying_, near.sample.data(), n, rows);
  for (int i = 0; i < n; i++) {
    const Vec3 sum = load3(rows + 4 * (size_t)i);
    const double length = norm(sum);
    const bool faces = length > tune::kNoDistance;
    near.set(N::Normal, i, faces ? (1 / length) * sum : normal(near.sample[i]));
  }
}

}  // namespace hp
