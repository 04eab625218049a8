#include "collision/poses.h"

#include <atomic>
#include <cmath>

#include "math/simd.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

namespace {

struct JointWeight {
  int joint;
  double weight;
};

// The largest weights of a vertex, largest first, scaled to a sum of 1.
int joint_weights(const Skin& s, int v, JointWeight out[Endpoint::kMost]) {
  int n = 0;
  for (int e = s.first_weight[v]; e < s.first_weight[v + 1]; e++) {
    JointWeight mine{s.weight_joint[e], s.weight[e]};
    int k = n;
    while (k > 0 && out[k - 1].weight < mine.weight) k--;
    if (k == Endpoint::kMost) continue;
    for (int l = std::min(n, Endpoint::kMost - 1); l > k; l--) out[l] = out[l - 1];
    out[k] = mine;
    n = std::min(n + 1, (int)Endpoint::kMost);
  }
  double sum = 0;
  for (int k = 0; k < n; k++) sum += out[k].weight;
  for (int k = 0; k < n; k++) out[k].weight /= sum;
  return n;
}

// Rotation of joint j relative to its parent.
Mat3 local_rotation(const Skin& s, const Kinematics& kin, int j) {
  return transposed(kin.xmat[s.body[s.parent[j]]]) * kin.xmat[s.body[j]];
}

}  // namespace

void Poses::restart(size_t shapes) {
  static std::atomic<uint64_t> last{0};
  stamp = ++last;
  posed.resize(shapes);
  fresh.assign(shapes, 0);
  placed = 0;
  features_.clear();
  spheres_.clear();
}

const std::vector<double>& Poses::features(const Skin& s) {
  for (const BlendFeatures& b : features_)
    if (b.skin == &s) return b.values;
  std::vector<double> f(s.features());
  for (size_t j = 1; j < s.joint.size(); j++) {
    const Mat3 local = local_rotation(s, kin, (int)j);
    for (int k = 0; k < 9; k++) f[9 * (j - 1) + k] = local.m[k] - (k % 4 == 0 ? 1 : 0);
  }
  features_.push_back({&s, std::move(f)});
  return features_.back().values;
}

void Poses::place(const CollisionShape& m, int i) {
  fresh[i] = 1;
  placed += m.skin ? 1 : tune::kRigidPose;
  if (m.skin)
    place_skin(m, posed[i]);
  else
    posed[i].place(m.hull, kin.xmat[m.body], kin.xpos[m.body]);
}

void Poses::place_skin(const CollisionShape& m, PosedShape& out) {
  const int n = (int)m.vertex.size();
  out.hull = &m.hull;
  out.R = kin.xmat[m.body];
  out.center = kin.xpos[m.body] + out.R * m.influences[0].center;
  out.xyz.resize(3 * (size_t)n);  // the first influence writes all of it
  out.rest.clear();
  const Skin& s = *m.skin;
  if (!m.blend_bounds.empty()) {
    const std::vector<double>& f = features(s);
    out.rest = m.hull.xyz;
    for (int c = 0; c < 3; c++)
      for (int v = 0; v < n; v++) {
        const double* row = &s.pose_blend[((size_t)m.vertex[v] * 3 + c) * f.size()];
        out.rest[(size_t)c * n + v] += inner(row, f.data(), (int)f.size());
      }
  }
  const double* rest = out.rest.empty() ? m.hull.xyz.data() : out.rest.data();
  for (const CollisionShape::WeightBlock& r : m.weight_blocks) {
    const CollisionShape::Influence& t = m.influences[r.influence];
    const Mat3& R = kin.xmat[t.body];
    // The joint's position at rest is the shape's centre minus where the joint carries that.
    double shift[3];
    store3(shift, kin.xpos[t.body] - R * (m.hull.center - t.center));
    blend(rest + r.first, n, r.count, R.m, shift, &m.weights[(size_t)r.influence * n + r.first],
          r.influence == 0, &out.xyz[r.first]);
  }
  out.moved();
}

BoundingSphere Poses::bounding_sphere(const CollisionShape& m) const {
  using Influence = CollisionShape::Influence;
  auto carried = [&](const Influence& t) { return kin.xpos[t.body] + kin.xmat[t.body] * t.center; };
  const Vec3 center = carried(m.influences[0]);
  if (!m.skin) return {center, m.hull.bound};
  auto away = [&](const Influence& t) { return norm(carried(t) - center); };
  return {center, m.hull.bound + m.weighted_bound(away)};
}

const BoundingSphere& Poses::cached_bounding_sphere(const std::vector<CollisionShape>& shapes,
                                                    int i) {
  if (spheres_.empty()) spheres_.assign(shapes.size(), {{}, -1});
  if (spheres_[i].radius < 0) spheres_[i] = bounding_sphere(shapes[i]);
  return spheres_[i];
}

Material Poses::material(const CollisionShape& m, const PosedShape& at, Vec3 x) const {
  if (!m.skin) return {-1, mul_t(kin.xmat[m.body], x - kin.xpos[m.body])};
  const Points p = at.points();
  return of_vertex(m, at, nearest(p.x, p.y, p.z, p.n, x.x, x.y, x.z), x);
}

Material Poses::of_vertex(const CollisionShape& m, const PosedShape& at, int v, Vec3 x) const {
  const Points p = at.points();
  JointWeight s[Endpoint::kMost];
  const int n = joint_weights(*m.skin, m.vertex[v], s);
  Mat3 turn;
  for (double& e : turn.m) e = 0;
  for (int k = 0; k < n; k++)
    for (int e = 0; e < 9; e++) turn.m[e] += s[k].weight * kin.xmat[m.skin->body[s[k].joint]].m[e];
  // The blend of two joints that twist a vertex against each other by half a turn is singular.
  const double volume = dot(turn.col(0), cross(turn.col(1), turn.col(2)));
  return {v, volume > tune::kSingularBlend ? solve3(turn, x - p.at(v))
                                           : mul_t(kin.xmat[m.body], x - p.at(v))};
}

Vec3 Poses::position(const CollisionShape& m, const PosedShape& at, const Material& point) const {
  if (point.vertex < 0) return kin.xpos[m.body] + kin.xmat[m.body] * point.local;
  Vec3 x = at.points().at(point.vertex);
  if (norm2(point.local) == 0) return x;
  JointWeight s[Endpoint::kMost];
  const int n = joint_weights(*m.skin, m.vertex[point.vertex], s);
  for (int k = 0; k < n; k++) x += s[k].weight * (kin.xmat[m.skin->body[s[k].joint]] * point.local);
  return x;
}

Endpoint Poses::endpoint(const CollisionShape& m, const PosedShape& at,
                         const Material& point) const {
  if (point.vertex < 0) return Endpoint::rigid(m.body, position(m, at, point));
  Endpoint e;
  const Skin& s = *m.skin;
  JointWeight share[Endpoint::kMost];
  e.count = joint_weights(s, m.vertex[point.vertex], share);
  const int n = (int)m.vertex.size(), v = point.vertex;
  const double* rest = at.rest.empty() ? m.hull.xyz.data() : at.rest.data();
  const Vec3 x = Vec3{rest[v], rest[n + v], rest[2 * n + v]} + point.local;
  for (int k = 0; k < e.count; k++) {
    const int b = s.body[share[k].joint];
    e.body[k] = b;
    e.weight[k] = share[k].weight;
    e.point[k] = kin.xpos[b] + kin.xmat[b] * (x - s.joint[share[k].joint]);
  }
  if (!s.pose_blend.empty()) e.bends = blend_rates(m, e, v);
  return e;
}

// What joint velocities do to a vertex by pose blend shapes:
// d vec(R_local)/dt = vec(R_local [w]x) for a joint that turns at w, in its own frame.
std::shared_ptr<const std::vector<Endpoint::Bend>> Poses::blend_rates(const CollisionShape& m,
                                                                      const Endpoint& e,
                                                                      int vertex) const {
  const Skin& s = *m.skin;
  auto bends = std::make_shared<std::vector<Endpoint::Bend>>();
  const int f = s.features();
  for (const CollisionShape::BlendBound& bound : m.blend_bounds) {
    const int j = bound.joint;
    const Mat3 local = local_rotation(s, kin, j);
    for (int axis = 0; axis < 3; axis++) {
      const int next = (axis + 1) % 3, last = (axis + 2) % 3;
      Vec3 rate;  // at rest
      for (int c = 0; c < 3; c++) {
        const double* row = &s.pose_blend[((size_t)m.vertex[vertex] * 3 + c) * f + 9 * (j - 1)];
        for (int r = 0; r < 3;
             r++)  // R [e]x: columns `next` and `last` are R's last and minus its next
          rate[c] +=
              row[3 * r + next] * local.m[3 * r + last] - row[3 * r + last] * local.m[3 * r + next];
      }
      Vec3 world;
      for (int k = 0; k < e.count; k++) world += e.weight[k] * (kin.xmat[e.body[k]] * rate);
      if (norm2(world) > tune::kNoBlendRate * tune::kNoBlendRate)
        bends->push_back({s.dof[j] + axis, world});
    }
  }
  return bends;
}

}  // namespace hp
