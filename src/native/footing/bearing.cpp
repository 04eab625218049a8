#include "footing/bearing.h"

#include <algorithm>
#include <cmath>

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

namespace {

// The function whose least value is looked for, at `a`, and its derivatives.
struct Tilt {
  double value = 0, gx = 0, gy = 0, hxx = 0, hxy = 0, hyy = 0;
};

Tilt tilt(const std::vector<BearingPoint>& points, Vec3 c, double ax, double ay,
          std::vector<double>& share) {
  double top = -1e300;
  for (const BearingPoint& p : points)
    if (p.carries > 0) top = std::max(top, ax * (p.at.x - c.x) + ay * (p.at.y - c.y));
  double sum = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  share.assign(points.size(), 0);
  for (size_t i = 0; i < points.size(); i++) {
    const BearingPoint& p = points[i];
    if (p.carries <= 0) continue;
    const double dx = p.at.x - c.x, dy = p.at.y - c.y;
    const double s = share[i] = p.carries * elementary::exp(ax * dx + ay * dy - top);
    sum += s, x += s * dx, y += s * dy;
    xx += s * dx * dx, xy += s * dx * dy, yy += s * dy * dy;
  }
  for (double& s : share) s /= sum;
  x /= sum, y /= sum;
  const double e = tune::kPressureSlack;
  return {top + elementary::log(sum) + 0.5 * e * (ax * ax + ay * ay),
          x + e * ax,
          y + e * ay,
          xx / sum - x * x + e,
          xy / sum - x * y,
          yy / sum - y * y + e};
}

}  // namespace

void spread_weight(const std::vector<BearingPoint>& points, Vec3 centre,
                   std::vector<double>& share) {
  share.assign(points.size(), 0);
  if (std::none_of(points.begin(), points.end(), [](auto& p) { return p.carries > 0; })) return;
  double ax = 0, ay = 0;
  Tilt t = tilt(points, centre, ax, ay, share);
  std::vector<double> tried;
  for (int i = 0; i < tune::kPressureSteps; i++) {
    if (elementary::hypot(t.gx, t.gy) < tune::kPressureMiss) return;
    const double det = t.hxx * t.hyy - t.hxy * t.hxy;
    const double dx = -(t.hyy * t.gx - t.hxy * t.gy) / det;
    const double dy = -(t.hxx * t.gy - t.hxy * t.gx) / det;
    const double slope = dx * t.gx + dy * t.gy;
    double step = 1;
    for (; step > tune::kLeastPressureStep; step *= 0.5) {
      const Tilt next = tilt(points, centre, ax + step * dx, ay + step * dy, tried);
      if (next.value > t.value + tune::kPressureGain * step * slope) continue;
      ax += step * dx, ay += step * dy;
      t = next;
      share.swap(tried);
      break;
    }
    if (step <= tune::kLeastPressureStep) return;
  }
}

// What begins to carry has no place yet that it comes from; what ends to keeps its velocity while it has load.
void Bearing::find_velocities(double dt) {
  before_.resize(points.size());
  for (size_t i = 0; i < points.size(); i++) {
    BearingPoint& p = points[i];
    Before& before = before_[i];
    const bool carries = p.carries > 0;
    p.timed = carries ? before.carried && dt > 0 : before.timed;
    p.velocity = before.velocity;
    if (carries && p.timed) p.velocity = {(p.at.x - before.x) / dt, (p.at.y - before.y) / dt, 0};
    before = {carries, p.timed, p.at.x, p.at.y, p.velocity};
  }
}

void Bearing::aim(Vec3 centre, double left, double dt) {
  find_velocities(dt);
  load_.resize(points.size(), 0);
  target_.assign(points.size(), 0);
  bool movable = false;
  double best = 0;
  for (size_t i = 0; i < points.size(); i++) {
    best = std::max(best, points[i].carries);
    movable |= points[i].shape >= 0 && points[i].carries > 0;
    if (points[i].shape < 0) load_[i] = 0;
  }
  if (movable) {
    spread_weight(points, centre, target_);
    for (size_t i = 0; i < points.size(); i++)
      target_[i] = points[i].shape < 0 ? 0 : left * best * target_[i];
  }
  const double all = total();
  left_ = all > 0 ? std::clamp(1 - pressed_ / all, 0.0, 1.0) : 1;
}

void Bearing::advance(double h) {
  const double share = 1 - elementary::exp(-h / tune::kLoadTime);
  for (size_t i = 0; i < load_.size(); i++) {
    load_[i] += share * (target_[i] - load_[i]);
    if (target_[i] == 0 && load_[i] < tune::kNoLoad) load_[i] = 0;
  }
}

bool Bearing::any() const {
  for (size_t i = 0; i < load_.size(); i++)
    if (load_[i] > 0 || target_[i] > 0) return true;
  return false;
}

double Bearing::total() const {
  double sum = 0;
  for (double load : load_) sum += load;
  return sum;
}

void Bearing::contacts_pressed(double weights, double dt) {
  pressed_ += (1 - elementary::exp(-dt / tune::kPressedTime)) * (weights - pressed_);
  if (weights == 0 && pressed_ < tune::kNoLoad) pressed_ = 0;
}

void Bearing::reset() {
  points.clear();
  before_.clear();
  target_.clear();
  load_.clear();
  pressed_ = 0;
  left_ = 1;
}

void Bearing::save(size_t count, std::vector<double>& out) const {
  out.push_back(pressed_);
  for (size_t i = 0; i < count; i++) out.push_back(i < load_.size() ? load_[i] : 0);
  for (size_t i = 0; i < count; i++) {
    const Before b = i < before_.size() ? before_[i] : Before{};
    out.insert(out.end(),
               {b.carried ? 1.0 : 0.0, b.timed ? 1.0 : 0.0, b.x, b.y, b.velocity.x, b.velocity.y});
  }
}

const double* Bearing::restore(size_t count, const double* in) {
  reset();
  pressed_ = *in++;
  load_.assign(in, in + count);
  target_.assign(count, 0);
  in += count;
  for (size_t i = 0; i < count; i++, in += 6)
    before_.push_back({in[0] != 0, in[1] != 0, in[2], in[3], {in[4], in[5], 0}});
  return in;
}

}  // namespace hp
