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

void find_near(const TouchingThing& thing, const PosedSkin& skin, const Placing& placing, double reach,
               const PointGrid* points, double off, const int* faces, int n_faces, NearRows& of_skin,
               NearRows& of_points) {
  struct Best {
    double d2;
    int face;
    Vec3 point;
  };
  const double inf = std::numeric_limits<double>::infinity();
  const double not_looked_at = -1;  // in place of a distance
  const double most = reach + off, limit = points ? most + tune::kBeyondReach : reach + tune::kReachRounding;
  std::vector<Vec3> at(skin.n);
  std::vector<double> far(skin.n);
  std::vector<Best> best(points ? points->points().size() : 0, Best{inf, -1, {}});
  std::vector<int> touched;
  std::vector<std::pair<double, int>> near;
  // Faces by the group of their first corner: those of what is far are not looked at one by one.
  std::vector<std::vector<int>> of_group(points ? skin.groups : 0);
  if (points)
    for (int f = 0; f < n_faces; f++) {
      const int* end = std::upper_bound(skin.first, skin.first + skin.groups, faces[3 * f]);
      of_group[end - skin.first - 1].push_back(f);
    }
  for (int k = 0; k < skin.frames; k++) {
    const size_t place = placing.one ? 0 : k;
    const Vec3 position = load3(placing.position + 3 * place);
    Mat3 turn;
    std::copy(placing.turn + 9 * place, placing.turn + 9 * place + 9, turn.m);
    bool any = false;
    for (int g = 0; g < skin.groups; g++) {
      const int from = skin.first[g], to = skin.first[g + 1];
      if (!skin.close[(size_t)k * skin.groups + g]) {
        std::fill(far.begin() + from, far.begin() + to, not_looked_at);
        continue;
      }
      const double* x = skin.x + 3 * ((size_t)k * skin.n + from);
      for (int v = from; v < to; v++, x += 3) at[v] = mul_t(turn, load3(x) - position);
      thing.distances(at.data() + from, to - from, limit, far.data() + from);
      any = any || to > from;
      for (int v = from; v < to; v++) {
        if (!(far[v] <= reach)) continue;
        of_skin.frame.push_back(k);
        of_skin.vertex.push_back(v);
        of_skin.distance.push_back(far[v]);
      }
    }
    if (!points || !any) continue;
    // A point of a face lies no farther from its nearest corner than the longest edge by root 3.
    near.clear();
    for (int g = 0; g < skin.groups; g++) {
      if (!skin.close[(size_t)k * skin.groups + g]) continue;
      for (const int f : of_group[g]) {
        const int a = faces[3 * f], b = faces[3 * f + 1], c = faces[3 * f + 2];
        const double d = std::min({far[a], far[b], far[c], limit});
        if (d < 0) continue;
        if (d > most) {
          const double edge2 =
              std::max({norm2(at[a] - at[b]), norm2(at[b] - at[c]), norm2(at[c] - at[a])});
          if (3 * (d - most) * (d - most) > edge2) continue;
        }
        near.emplace_back(d, f);
      }
    }
    // Nearest first: what is found early spares the rest, where points have many faces in reach.
    if (points->cell_size() < reach) std::sort(near.begin(), near.end());
    for (const auto& [d, f] : near) {
      const Vec3 a = at[faces[3 * f]], b = at[faces[3 * f + 1]], c = at[faces[3 * f + 2]];
      Box3 box;
      box.add(a), box.add(b), box.add(c);
      const Vec3 n = cross(b - a, c - a);
      const double longest = std::max({norm2(b - a), norm2(c - a), norm2(c - b)});
      const bool sliver = !(norm2(n) > 1e-20 * longest * longest);
      const triangles::Triangle t{vec(a), vec(b), vec(c), f, sliver};
      Box3 around = box;
      around.grow(reach);
      points->in_box(around, [&](int i) {
        const Vec3 p = points->points()[i];
        const double least = box_distance2(box, p);
        Best& found = best[i];
        if (least > reach * reach || least > found.d2) return;
        const Vec3 q = vec(triangles::closest_on_triangle(vec(p), t));
        const double d2 = norm2(p - q);
        if (d2 > reach * reach || d2 > found.d2 || (d2 == found.d2 && f > found.face)) return;
        if (found.face < 0) touched.push_back(i);
        found = {d2, f, q};
      });
    }
    std::sort(touched.begin(), touched.end());
    for (int i : touched) {
      const Best& b = best[i];
      int corner = faces[3 * b.face];
      for (int c = 1; c < 3; c++) {
        const int other = faces[3 * b.face + c];
        if (norm2(at[other] - b.point) < norm2(at[corner] - b.point)) corner = other;
      }
      of_points.frame.push_back(k);
      of_points.vertex.push_back(i);
      of_points.nearest.push_back(corner);
      of_points.distance.push_back(std::sqrt(b.d2));
      of_points.point.insert(of_points.point.end(), {b.point.x, b.point.y, b.point.z});
      best[i] = Best{inf, -1, {}};
    }
    touched.clear();
  }
}

}  // namespace hp
