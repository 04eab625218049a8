#include "geometry/contact_manifold.h"

#include <algorithm>
#include <cmath>

#include "geometry/near_face.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

namespace {

// The corners of a convex polygon that say where it is: all, or those at which it has turned far enough.
std::vector<FacePoint> main_corners(const std::vector<FacePoint>& face) {
  if (face.size() <= tune::kFaceCorners) return face;
  const double enough = 2 * M_PI / tune::kFaceCorners;
  std::vector<FacePoint> out;
  double turned = 2 * M_PI;
  const size_t n = face.size();
  for (size_t k = 0; k < n; k++) {
    const FacePoint &p = face[(k + n - 1) % n], &q = face[k], &r = face[(k + 1) % n];
    const double au = q.u - p.u, av = q.v - p.v, bu = r.u - q.u, bv = r.v - q.v;
    turned += elementary::atan2(au * bv - av * bu, au * bu + av * bv);
    if (turned < enough) continue;
    out.push_back(q);
    turned = 0;
  }
  return out;
}

// The plane of a near face, through its widest three corners, or the line of an edge.
class FacePlane {
 public:
  explicit FacePlane(const std::vector<FacePoint>& face) : face_(main_corners(face)) {
    if (face.size() == 2) return;
    for (size_t k = 1; k < face_.size(); k++)
      for (size_t l = k + 1; l < face_.size(); l++) {
        const double area = cross2(face_[0], face_[k], face_[l]);
        if (area > widest_) widest_ = area, i_ = k, j_ = l;
      }
  }

  // Its height at a point.
  double at(FacePoint q) const {
    const FacePoint &o = face_[0], &e = face_[1];
    if (face_.size() == 2) {
      double u = e.u - o.u, v = e.v - o.v, along = (q.u - o.u) * u + (q.v - o.v) * v;
      double length2 = u * u + v * v;
      if (length2 == 0) return std::min(o.height, e.height);  // an edge along the normal
      return o.height + along / length2 * (e.height - o.height);
    }
    double f = cross2(o, q, face_[j_]) / widest_, g = cross2(o, face_[i_], q) / widest_;
    return o.height + f * (face_[i_].height - o.height) + g * (face_[j_].height - o.height);
  }

 private:
  const std::vector<FacePoint> face_;
  size_t i_ = 1, j_ = 2;
  double widest_ = 0;
};

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
  A = clip(std::move(A), main_corners(B));
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
