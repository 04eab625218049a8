#include "geometry/contact_manifold.h"

#include <algorithm>
#include <cmath>

#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

namespace {

// A point of a face: along the two tangents, and along the normal [m].
struct FacePoint {
  double u, v, height;
};

double cross2(FacePoint o, FacePoint a, FacePoint b) {
  return (a.u - o.u) * (b.v - o.v) - (a.v - o.v) * (b.u - o.u);
}

// Vertices within tol of the face nearest along -n, projected on the plane, as a convex polygon
// in counter-clockwise order (monotone chain). A disc that is wholly that near gives eight points
// of its rim, another its nearest point alone: a round side is no face.
std::vector<FacePoint> near_face(const PosedShape& s, Vec3 n, Vec3 t, Vec3 b, double tol) {
  Points p = s.points();
  Support swept = s.support();
  double low = dot(n, p.at(p.support(-n)));
  std::vector<FacePoint> pts;
  pts.reserve(64);
  auto add = [&](Vec3 x) { pts.push_back({dot(t, x), dot(b, x), dot(n, x)}); };
  for (int i = 0; i < p.n; i++) {
    Vec3 x = p.at(i);
    if (dot(n, x) > low + tol) continue;
    if (swept.rim == 0) {
      add(x);
    } else if (2 * (s.reach(n) - s.hull->radius) > tol) {
      add(x + swept.on_rim(-n));
    } else {
      for (int k = 0; k < 8; k++)
        add(x + swept.on_rim(elementary::cos(0.25 * M_PI * k) * t +
                             elementary::sin(0.25 * M_PI * k) * b));
    }
  }
  std::sort(pts.begin(), pts.end(),
            [](FacePoint x, FacePoint y) { return x.u < y.u || (x.u == y.u && x.v < y.v); });
  if (pts.size() < 3) return pts;
  std::vector<FacePoint> hull(2 * pts.size());
  size_t k = 0;
  for (size_t i = 0; i < pts.size(); hull[k++] = pts[i++])
    while (k >= 2 && cross2(hull[k - 2], hull[k - 1], pts[i]) <= tune::kStraight) k--;
  for (size_t i = pts.size() - 1, floor = k + 1; i-- > 0; hull[k++] = pts[i])
    while (k >= floor && cross2(hull[k - 2], hull[k - 1], pts[i]) <= tune::kStraight) k--;
  hull.resize(k - 1);
  return hull;
}

// The plane of a near face, through its widest three corners, or the line of an edge.
class FacePlane {
 public:
  explicit FacePlane(const std::vector<FacePoint>& face) : face_(face) {
    if (face.size() == 2) return;
    for (size_t k = 1; k < face.size(); k++)
      for (size_t l = k + 1; l < face.size(); l++) {
        const double area = cross2(face[0], face[k], face[l]);
        if (area > widest_) widest_ = area, i_ = k, j_ = l;
      }
  }

  // Its height at a point.
  double at(FacePoint q) const {
    const FacePoint &o = face_[0], &e = face_[1];
    if (face_.size() == 2) {
      double u = e.u - o.u, v = e.v - o.v, along = (q.u - o.u) * u + (q.v - o.v) * v;
      return o.height + along / (u * u + v * v) * (e.height - o.height);
    }
    double f = cross2(o, q, face_[j_]) / widest_, g = cross2(o, face_[i_], q) / widest_;
    return o.height + f * (face_[i_].height - o.height) + g * (face_[j_].height - o.height);
  }

 private:
  const std::vector<FacePoint>& face_;
  size_t i_ = 1, j_ = 2;
  double widest_ = 0;
};

// A segment or polygon, cut by the edges of a convex polygon.
std::vector<FacePoint> clip(std::vector<FacePoint> face, const std::vector<FacePoint>& by) {
  for (size_t e = 0; e < by.size() && !face.empty(); e++) {
    FacePoint p = by[e], q = by[(e + 1) % by.size()];
    std::vector<FacePoint> out;
    out.reserve(face.size() + 2);
    for (size_t i = 0; i < face.size(); i++) {
      FacePoint c = face[i], d = face[(i + 1) % face.size()];
      double fc = cross2(p, q, c), fd = cross2(p, q, d);
      if (fc >= 0) out.push_back(c);
      if ((fc < 0) != (fd < 0)) {
        double f = fc / (fc - fd);
        out.push_back({c.u + f * (d.u - c.u), c.v + f * (d.v - c.v), 0});
      }
    }
    face = out;
  }
  return face;
}

// The extreme points along `most` evenly turned directions.
std::vector<FacePoint> spread_out(const std::vector<FacePoint>& face, int most) {
  std::vector<FacePoint> pick;
  pick.reserve(most);
  for (int k = 0; k < most; k++) {
    double angle = 2 * M_PI * (k + 0.125) / most, cu = elementary::cos(angle),
           cv = elementary::sin(angle);
    FacePoint best = face[0];
    for (FacePoint q : face)
      if (cu * q.u + cv * q.v > cu * best.u + cv * best.v) best = q;
    bool known = false;
    for (FacePoint q : pick)
      known |= elementary::hypot(q.u - best.u, q.v - best.v) < tune::kSameCorner;
    if (!known) pick.push_back(best);
  }
  return pick;
}

}  // namespace

int face_manifold(const PosedShape& a, const PosedShape& b, Vec3 n, double tol, int most, Vec3* pa,
                  Vec3* pb) {
  Vec3 t, s;
  tangents(n, t, s);
  std::vector<FacePoint> A = near_face(a, n, t, s, tol), B = near_face(b, -n, t, s, tol);
  if (A.size() < 2 || B.size() < 2 || (A.size() == 2 && B.size() == 2)) return 0;
  const std::vector<FacePoint> face_a = A, face_b = B;
  if (B.size() == 2) std::swap(A, B);
  A = clip(std::move(A), B);
  if (A.empty()) return 0;
  const std::vector<FacePoint> pick = spread_out(A, most);
  const FacePlane plane_a(face_a), plane_b(face_b);
  for (size_t k = 0; k < pick.size(); k++) {
    Vec3 base = pick[k].u * t + pick[k].v * s;
    pa[k] = base + (plane_a.at(pick[k]) - a.hull->radius) * n;
    pb[k] = base + (b.hull->radius - plane_b.at(pick[k])) * n;  // of -n
  }
  return (int)pick.size();
}

}  // namespace hp
