#include "collision/collision_shape.h"

#include <cmath>

#include "math/simd.h"

namespace hp {

namespace {

constexpr int kBlock = 4;         // vertices are posed so many at once
constexpr double kNoBend = 1e-9;  // rates of points that are left out [m/rad]
const double kFrobenius = 2 * std::sqrt(2.0);  // of the change of a rotation by half a turn

// Weights of the joints that carry more than a sliver of a vertex, largest first.
struct Share {
  int joint;
  double weight;
};

int shares_of(const Skin& s, int v, Share out[Endpoint::kMost]) {
  int n = 0;
  for (int e = s.first[v]; e < s.first[v + 1]; e++) {
    Share mine{s.at[e], s.weight[e]};
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

}  // namespace

void CollisionShape::finish() {
  if (!skin) {
    shape.finish();
    ties = {{body, 1, shape.center, shape.bound, shape.center}};
    return;
  }
  const Skin& s = *skin;
  const int n = (int)vertex.size(), joints = (int)s.joint.size();
  std::vector<double> sum(joints, 0), most(joints, 0), reach(joints, 0);
  for (int v : vertex)
    for (int e = s.first[v]; e < s.first[v + 1]; e++) {
      const int j = s.at[e];
      sum[j] += s.weight[e];
      most[j] = std::max(most[j], s.weight[e]);
      reach[j] = std::max(reach[j], norm(s.rest[v] - s.joint[j]));
    }
  stretches.clear();
  double longest = 0;  // no blend shape moves a vertex farther
  if (!s.bend.empty()) {
    const int f = s.features();
    for (int j = 1; j < joints; j++) {
      double largest = 0;
      for (int v : vertex) {
        double square = 0;
        for (int c = 0; c < 3; c++)
          for (int k = 0; k < 9; k++) {
            double b = s.bend[((size_t)v * 3 + c) * f + 9 * (j - 1) + k];
            square += b * b;
          }
        largest = std::max(largest, square);
      }
      if (largest == 0) continue;
      stretches.push_back({j, std::sqrt(largest)});
      longest += kFrobenius * stretches.back().most;
    }
  }
  std::vector<int> order;
  for (int j = 0; j < joints; j++)
    if (most[j] > 0) order.push_back(j);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return sum[a] > sum[b]; });
  // Vertices that hang on the same joints stand side by side.
  auto hangs = [&](int v) {
    std::vector<char> on(joints, 0), mine;
    for (int e = s.first[v]; e < s.first[v + 1]; e++) on[s.at[e]] = 1;
    for (int j : order) mine.push_back(on[j]);
    return mine;
  };
  std::vector<std::pair<std::vector<char>, int>> sorted;
  for (int v : vertex) sorted.push_back({hangs(v), v});
  std::sort(sorted.begin(), sorted.end());
  for (int i = 0; i < n; i++) vertex[i] = sorted[i].second;
  shape.vertices.clear();
  for (int v : vertex) shape.vertices.push_back(s.rest[v]);
  shape.finish();
  shape.bound += longest;
  ties.clear();
  runs.clear();
  weights.assign(order.size() * (size_t)n, 0);
  for (size_t k = 0; k < order.size(); k++) {
    const int j = order[k];
    ties.push_back({s.body[j], most[j], {}, reach[j] + longest, shape.center - s.joint[j]});
    for (int i = 0; i < n; i++)
      for (int e = s.first[vertex[i]]; e < s.first[vertex[i] + 1]; e++)
        if (s.at[e] == j) weights[k * n + i] = s.weight[e];
    for (int i = 0, end; i < n; i = end) {
      end = std::min(n, i + kBlock);
      const double* w = &weights[k * n];
      if (std::all_of(w + i, w + end, [](double x) { return x == 0; })) continue;
      if (!runs.empty() && runs.back().tie == (int)k && runs.back().first + runs.back().count == i)
        runs.back().count += end - i;
      else
        runs.push_back({(int)k, i, end - i});
    }
  }
  body = ties[0].body;
}

const std::vector<double>& Poses::features(const Skin& s) {
  for (const Bends& b : bends)
    if (b.skin == &s) return b.features;
  std::vector<double> f(s.features());
  for (size_t j = 1; j < s.joint.size(); j++) {
    const Mat3 local = transposed(kin.xmat[s.body[s.parent[j]]]) * kin.xmat[s.body[j]];
    for (int k = 0; k < 9; k++) f[9 * (j - 1) + k] = local.m[k] - (k % 4 == 0 ? 1 : 0);
  }
  bends.push_back({&s, std::move(f)});
  return bends.back().features;
}

void Poses::place(const std::vector<CollisionShape>& shapes, int i) {
  const CollisionShape& m = shapes[i];
  PosedShape& out = placed[i];
  fresh[i] = 1;
  if (!m.skin) {
    out.place(m.shape, kin.xmat[m.body], kin.xpos[m.body]);
    return;
  }
  const int n = (int)m.vertex.size();
  out.shape = &m.shape;
  out.R = kin.xmat[m.body];
  out.center = kin.xpos[m.body] + out.R * m.ties[0].middle;
  out.xyz.assign(3 * (size_t)n, 0);
  out.rest.clear();
  const Skin& s = *m.skin;
  if (!m.stretches.empty()) {
    const std::vector<double>& f = features(s);
    out.rest = m.shape.xyz;
    for (int c = 0; c < 3; c++)
      for (int v = 0; v < n; v++) {
        const double* row = &s.bend[((size_t)m.vertex[v] * 3 + c) * f.size()];
        out.rest[(size_t)c * n + v] += inner(row, f.data(), (int)f.size());
      }
  }
  const double* rest = out.rest.empty() ? m.shape.xyz.data() : out.rest.data();
  for (const CollisionShape::Run& r : m.runs) {
    const CollisionShape::Tie& t = m.ties[r.tie];
    const Mat3& R = kin.xmat[t.body];
    // The joint's place at rest is the shape's centre less `middle`.
    double shift[3];
    store3(shift, kin.xpos[t.body] - R * (m.shape.center - t.middle));
    blend(rest + r.first, n, r.count, R.m, shift, &m.weights[(size_t)r.tie * n + r.first],
          &out.xyz[r.first]);
  }
  double lo[3], hi[3];
  for (int c = 0; c < 3; c++) limits(&out.xyz[(size_t)c * n], n, lo[c], hi[c]);
  out.box = {load3(lo), load3(hi)};
}

Poses::Ball Poses::ball(const CollisionShape& m) const {
  auto middle = [&](const CollisionShape::Tie& t) { return kin.xpos[t.body] + kin.xmat[t.body] * t.middle; };
  const Vec3 center = middle(m.ties[0]);
  if (!m.skin) return {center, m.shape.bound};
  return {center, m.shape.bound + m.most_of([&](const CollisionShape::Tie& t) { return norm(middle(t) - center); })};
}

const Poses::Ball& Poses::known_ball(const std::vector<CollisionShape>& shapes, int i) {
  if (balls.empty()) balls.assign(shapes.size(), {{}, -1});
  if (balls[i].radius < 0) balls[i] = ball(shapes[i]);
  return balls[i];
}

Material Poses::material(const CollisionShape& m, const PosedShape& at, Vec3 x) const {
  if (!m.skin) return {-1, mul_t(kin.xmat[m.body], x - kin.xpos[m.body])};
  // Carried like the nearest vertex.
  const Points p = at.points();
  const int v = nearest(p.x, p.y, p.z, p.n, x.x, x.y, x.z);
  Share s[Endpoint::kMost];
  const int n = shares_of(*m.skin, m.vertex[v], s);
  Mat3 turn;
  for (double& e : turn.m) e = 0;
  for (int k = 0; k < n; k++)
    for (int e = 0; e < 9; e++) turn.m[e] += s[k].weight * kin.xmat[m.skin->body[s[k].joint]].m[e];
  // Two joints that twist a vertex against each other by half a turn carry nothing beside it.
  const double volume = dot(turn.col(0), cross(turn.col(1), turn.col(2)));
  return {v, volume > 0.1 ? solve3(turn, x - p.at(v)) : mul_t(kin.xmat[m.body], x - p.at(v))};
}

Vec3 Poses::position(const CollisionShape& m, const PosedShape& at, const Material& point) const {
  if (point.vertex < 0) return kin.xpos[m.body] + kin.xmat[m.body] * point.local;
  Vec3 x = at.points().at(point.vertex);
  if (norm2(point.local) == 0) return x;
  Share s[Endpoint::kMost];
  const int n = shares_of(*m.skin, m.vertex[point.vertex], s);
  for (int k = 0; k < n; k++)
    x += s[k].weight * (kin.xmat[m.skin->body[s[k].joint]] * point.local);
  return x;
}

Endpoint Poses::endpoint(const CollisionShape& m, const PosedShape& at, const Material& point) const {
  if (point.vertex < 0) return Endpoint::rigid(m.body, position(m, at, point));
  Endpoint e;
  const Skin& s = *m.skin;
  Share share[Endpoint::kMost];
  e.count = shares_of(s, m.vertex[point.vertex], share);
  const int n = (int)m.vertex.size(), v = point.vertex;
  const double* rest = at.rest.empty() ? m.shape.xyz.data() : at.rest.data();
  const Vec3 x = Vec3{rest[v], rest[n + v], rest[2 * n + v]} + point.local;
  for (int k = 0; k < e.count; k++) {
    const int b = s.body[share[k].joint];
    e.body[k] = b;
    e.weight[k] = share[k].weight;
    e.point[k] = kin.xpos[b] + kin.xmat[b] * (x - s.joint[share[k].joint]);
  }
  if (s.bend.empty()) return e;
  // d vec(R_local)/dt = vec(R_local [w]x) for a joint that turns at w, in its own frame.
  auto bends = std::make_shared<std::vector<Endpoint::Bend>>();
  const int f = s.features();
  for (const CollisionShape::Stretch& stretch : m.stretches) {
    const int j = stretch.joint;
    const Mat3 local = transposed(kin.xmat[s.body[s.parent[j]]]) * kin.xmat[s.body[j]];
    for (int axis = 0; axis < 3; axis++) {
      const int next = (axis + 1) % 3, last = (axis + 2) % 3;
      Vec3 rate;  // at rest
      for (int c = 0; c < 3; c++) {
        const double* row = &s.bend[((size_t)m.vertex[v] * 3 + c) * f + 9 * (j - 1)];
        for (int r = 0; r < 3; r++)  // R [e]x: columns `next` and `last` are R's last and minus its next
          rate[c] += row[3 * r + next] * local.m[3 * r + last] - row[3 * r + last] * local.m[3 * r + next];
      }
      Vec3 world;
      for (int k = 0; k < e.count; k++) world += e.weight[k] * (kin.xmat[e.body[k]] * rate);
      if (norm2(world) > kNoBend * kNoBend) bends->push_back({s.dof[j] + axis, world});
    }
  }
  e.bends = bends;
  return e;
}

void ways(const std::vector<CollisionShape>& shapes, const Poses& from, const Poses& to,
          const std::vector<char>& active, std::vector<double>& way) {
  const int bodies = (int)from.kin.xpos.size();
  static thread_local std::vector<double> turn, step;  // 2 sin of half a body's turn; its origin's way
  turn.resize(bodies), step.resize(bodies);
  auto turned = [](Quat p, Quat q) {
    const double cosine = std::fabs(p.w * q.w + p.x * q.x + p.y * q.y + p.z * q.z);
    return 2 * std::sqrt(std::max(0.0, 1 - cosine * cosine));
  };
  for (int b = 1; b < bodies; b++) {
    if (!active[b]) continue;
    turn[b] = turned(from.kin.xquat[b], to.kin.xquat[b]);
    step[b] = norm(to.kin.xpos[b] - from.kin.xpos[b]);
  }
  const Skin* known = nullptr;
  static thread_local std::vector<double> change;  // of the joints' local rotation matrices
  way.resize(shapes.size());
  for (size_t i = 0; i < shapes.size(); i++) {
    const CollisionShape& m = shapes[i];
    if (!active[m.body]) {
      way[i] = 0;
      continue;
    }
    if (!m.skin) {
      const Vec3 c = m.shape.center;
      const Vec3 a = from.kin.xpos[m.body] + from.kin.xmat[m.body] * c,
                 b = to.kin.xpos[m.body] + to.kin.xmat[m.body] * c;
      way[i] = norm(b - a) + turn[m.body] * m.shape.bound;
      continue;
    }
    way[i] = m.most_of([&](const CollisionShape::Tie& t) { return step[t.body] + turn[t.body] * t.reach; });
    if (m.stretches.empty()) continue;
    const Skin& s = *m.skin;
    if (known != &s) {
      known = &s;
      change.assign(s.joint.size(), 0);
      for (size_t j = 1; j < s.joint.size(); j++) {
        auto local = [&](const Poses& p) {
          return conjugate(p.kin.xquat[s.body[s.parent[j]]]) * p.kin.xquat[s.body[j]];
        };
        change[j] = std::sqrt(2.0) * turned(local(from), local(to));
      }
    }
    for (const CollisionShape::Stretch& e : m.stretches) way[i] += e.most * change[e.joint];
  }
}

}  // namespace hp
