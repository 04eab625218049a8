#include "labels/touching.h"

#include "tuning.h"

#include <algorithm>
#include <cmath>

namespace hp {

namespace tune = tuning::labels;

namespace {

triangles::Vec vec(Vec3 v) { return {v.x, v.y, v.z}; }
Vec3 vec(triangles::Vec v) { return {v.x, v.y, v.z}; }

// Distance to the nearest triangle, or more than `limit` where none is as near.
double to_triangles(const triangles::Tree& tree, Vec3 p, double limit) {
  triangles::Vec point{};
  double distance;
  return tree.closest(vec(p), -1, point, distance, limit) < 0 ? 2 * limit + 1 : distance;
}

double box_distance2(const Box3& box, Vec3 p) {
  double sum = 0;
  for (int k = 0; k < 3; k++) {
    const double d = std::max({box.lo[k] - p[k], p[k] - box.hi[k], 0.0});
    sum += d * d;
  }
  return sum;
}

}  // namespace

void TouchingShape::lower(const Vec3* points, int n, double limit, double* least) const {
  const auto each = [&](const auto& distance) {
    for (int i = 0; i < n; i++) least[i] = std::min(least[i], distance(mul_t(R, points[i] - pos)));
  };
  const double x = size.x, y = size.y, z = size.z;
  switch (kind) {
    case Kind::Plane:
      return each([&](Vec3 p) { return std::max(dot(size, p) - offset, 0.0); });
    case Kind::Box:
      return each([&](Vec3 p) {
        const Vec3 d{std::max(std::fabs(p.x) - x, 0.0), std::max(std::fabs(p.y) - y, 0.0),
                     std::max(std::fabs(p.z) - z, 0.0)};
        return norm(d);
      });
    case Kind::Capsule:
      return each([&](Vec3 p) {
        const double end = std::max(std::fabs(p.z) - y, 0.0);
        return std::max(norm({p.x, p.y, end}) - x, 0.0);
      });
    case Kind::Cylinder:
      return each([&](Vec3 p) {
        const double side = std::max(std::sqrt(p.x * p.x + p.y * p.y) - x, 0.0);
        const double end = std::max(std::fabs(p.z) - y, 0.0);
        return std::sqrt(side * side + end * end);
      });
    default:
      for (int i = 0; i < n; i++) {
        const Vec3 p = mul_t(R, points[i] - pos);
        const double most = std::min(limit, least[i]);
        // Outside of a face's plane: no nearer than that.
        double out = kind == Kind::Hull ? 0 : 1;
        for (size_t f = 0; f < normals.size() && out <= most; f++)
          out = std::max(out, dot(normals[f], p) - offsets[f]);
        if (out > most && kind == Kind::Hull) continue;
        least[i] = std::min(least[i], out == 0 ? 0 : to_triangles(*tree, p, most));
      }
  }
}

void TouchingThing::distances(const Vec3* points, int n, double limit, double* out) const {
  std::fill(out, out + n, std::numeric_limits<double>::infinity());
  for (const TouchingShape& s : shapes) s.lower(points, n, limit, out);
}

bool TouchingThing::within(Vec3 point, double reach) const {
  double least = std::numeric_limits<double>::infinity();
  for (const TouchingShape& s : shapes) {
    s.lower(&point, 1, reach, &least);
    if (least <= reach) return true;
  }
  return false;
}

PointGrid::PointGrid(std::vector<Vec3> points) : points_(std::move(points)) {
  if (points_.empty()) return;
  for (Vec3 p : points_) box_.add(p);
  const Vec3 extent = box_.hi - box_.lo;
  size_ = std::max({extent.x, extent.y, extent.z, 1e-9}) / tune::kGridCells;
  per_length_ = 1 / size_;
  for (int k = 0; k < 3; k++) count_[k] = std::min(tune::kGridCells, (int)(extent[k] / size_) + 1);
  const auto index = [&](Vec3 p) {
    return (cell(p.x, 0) * count_[1] + cell(p.y, 1)) * count_[2] + cell(p.z, 2);
  };
  first_.assign((size_t)count_[0] * count_[1] * count_[2] + 1, 0);
  for (Vec3 p : points_) first_[index(p) + 1]++;
  for (size_t i = 1; i < first_.size(); i++) first_[i] += first_[i - 1];
  order_.resize(points_.size());
  std::vector<int> next = first_;
  for (size_t i = 0; i < points_.size(); i++) order_[next[index(points_[i])]++] = (int)i;
}

namespace {

// One search: rows of vertices and of points, frame by frame.
class NearSearch {
 public:
  NearSearch(const NearQuery& query, NearRows& of_skin, NearRows& of_points)
      : q_(query), of_skin_(of_skin), of_points_(of_points) {
    at_.resize(q_.skin.n);
    far_.resize(q_.skin.n);
    most_ = q_.reach + q_.off;
    limit_ = q_.points ? most_ + tune::kPointSearchMargin : q_.reach + tune::kReachRounding;
    if (!q_.points) return;
    best_.assign(q_.points->points().size(), Best{});
    // Faces by the group of their first corner: those of what is far are not looked at one by one.
    of_group_.resize(q_.skin.groups);
    for (int f = 0; f < q_.n_faces; f++) {
      const int* end =
          std::upper_bound(q_.skin.first, q_.skin.first + q_.skin.groups, q_.faces[3 * f]);
      of_group_[end - q_.skin.first - 1].push_back(f);
    }
  }

  void frame(int k) {
    const bool any = vertices(k);
    if (!q_.points || !any) return;
    near_faces(k);
    for (const auto& [d, f] : near_) points_near(f);
    report(k);
  }

 private:
  // The nearest face of a point so far; face -1: none.
  struct Best {
    double d2 = std::numeric_limits<double>::infinity();
    int face = -1;
    Vec3 point;
  };

  // Distances of the vertices of the groups that may be near, and the rows of those that are; false if
  // there are no such vertices.
  bool vertices(int k) {
    const PosedSkin& skin = q_.skin;
    const size_t place = q_.placing.one ? 0 : k;
    const Vec3 position = load3(q_.placing.position + 3 * place);
    Mat3 turn;
    std::copy(q_.placing.turn + 9 * place, q_.placing.turn + 9 * place + 9, turn.m);
    bool any = false;
    for (int g = 0; g < skin.groups; g++) {
      const int from = skin.first[g], to = skin.first[g + 1];
      if (!skin.close[(size_t)k * skin.groups + g]) {
        std::fill(far_.begin() + from, far_.begin() + to, not_looked_at);
        continue;
      }
      const double* x = skin.x + 3 * ((size_t)k * skin.n + from);
      for (int v = from; v < to; v++, x += 3) at_[v] = mul_t(turn, load3(x) - position);
      q_.thing.distances(at_.data() + from, to - from, limit_, far_.data() + from);
      any = any || to > from;
      for (int v = from; v < to; v++) {
        if (!(far_[v] <= q_.reach)) continue;
        of_skin_.frame.push_back(k);
        of_skin_.vertex.push_back(v);
        of_skin_.distance.push_back(far_[v]);
      }
    }
    return any;
  }

  // The faces that may have a point in reach, into near_, with the distance of their nearest corner.
  // A point of a face lies no farther from its nearest corner than the longest edge by root 3.
  void near_faces(int k) {
    near_.clear();
    for (int g = 0; g < q_.skin.groups; g++) {
      if (!q_.skin.close[(size_t)k * q_.skin.groups + g]) continue;
      for (const int f : of_group_[g]) {
        const int a = q_.faces[3 * f], b = q_.faces[3 * f + 1], c = q_.faces[3 * f + 2];
        const double d = std::min({far_[a], far_[b], far_[c], limit_});
        if (d < 0) continue;
        if (d > most_) {
          const double edge2 =
              std::max({norm2(at_[a] - at_[b]), norm2(at_[b] - at_[c]), norm2(at_[c] - at_[a])});
          if (3 * (d - most_) * (d - most_) > edge2) continue;
        }
        near_.emplace_back(d, f);
      }
    }
    // Nearest first: what is found early spares the rest, where points have many faces in reach.
    if (q_.points->cell_size() < q_.reach) std::sort(near_.begin(), near_.end());
  }

  // Points that a face is nearer to than all faces before.
  void points_near(int f) {
    const double reach = q_.reach;
    const int* corner = q_.faces + 3 * f;
    const Vec3 a = at_[corner[0]], b = at_[corner[1]], c = at_[corner[2]];
    Box3 box;
    box.add(a), box.add(b), box.add(c);
    const Vec3 n = cross(b - a, c - a);
    const double longest = std::max({norm2(b - a), norm2(c - a), norm2(c - b)});
    const bool sliver = !(norm2(n) > 1e-20 * longest * longest);
    const triangles::Triangle t{vec(a), vec(b), vec(c), f, sliver};
    Box3 around = box;
    around.grow(reach);
    q_.points->in_box(around, [&](int i) {
      const Vec3 p = q_.points->points()[i];
      const double least = box_distance2(box, p);
      Best& found = best_[i];
      if (least > reach * reach || least > found.d2) return;
      const Vec3 q = vec(triangles::closest_on_triangle(vec(p), t));
      const double d2 = norm2(p - q);
      if (d2 > reach * reach || d2 > found.d2 || (d2 == found.d2 && f > found.face)) return;
      if (found.face < 0) touched_.push_back(i);
      found = {d2, f, q};
    });
  }

  // Rows of the points that are near, with the nearest corner of their face.
  void report(int k) {
    std::sort(touched_.begin(), touched_.end());
    for (int i : touched_) {
      const Best& b = best_[i];
      int corner = q_.faces[3 * b.face];
      for (int c = 1; c < 3; c++) {
        const int other = q_.faces[3 * b.face + c];
        if (norm2(at_[other] - b.point) < norm2(at_[corner] - b.point)) corner = other;
      }
      of_points_.frame.push_back(k);
      of_points_.vertex.push_back(i);
      of_points_.nearest.push_back(corner);
      of_points_.distance.push_back(std::sqrt(b.d2));
      of_points_.point.insert(of_points_.point.end(), {b.point.x, b.point.y, b.point.z});
      best_[i] = Best{};
    }
    touched_.clear();
  }

  static constexpr double not_looked_at = -1;  // in place of a distance

  const NearQuery& q_;
  NearRows &of_skin_, &of_points_;
  double most_, limit_;       // how far corners of near faces may be, and distances are known [m]
  std::vector<Vec3> at_;      // vertices in the thing's frame
  std::vector<double> far_;   // their distances from the thing [m]
  std::vector<Best> best_;    // per point
  std::vector<int> touched_;  // points that have one
  std::vector<std::pair<double, int>> near_;
  std::vector<std::vector<int>> of_group_;
};

}  // namespace

void find_near(const NearQuery& query, NearRows& of_skin, NearRows& of_points) {
  NearSearch search(query, of_skin, of_points);
  for (int k = 0; k < query.skin.frames; k++) search.frame(k);
}

}  // namespace hp
