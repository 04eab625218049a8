#include "assembly/limit_calls.h"

namespace hp::assembly {

void set_strength(Stepper& s, int person, Doubles limits) {
  std::vector<Drive>& drives = s.system.drives;
  need(person >= 0 && person < (int)drives.size() &&
           (int)limits.shape(0) == drives[person].ball_count() + 1,
       "set_strength: bad person or length");
  drives[person].limits = list<double>(limits);
}

void set_joint_ranges(Stepper& s, int person, Doubles axes, Doubles lower, Doubles upper) {
  std::vector<Drive>& drives = s.system.drives;
  need(person >= 0 && person < (int)drives.size(), "set_joint_ranges: bad person");
  const size_t n = drives[person].ball_count();
  need(axes.size() == 9 * n && lower.size() == 3 * n && upper.size() == 3 * n,
       "set_joint_ranges: axes (n, 3, 3), lower (n, 3), upper (n, 3)");
  std::vector<JointRange> ranges(n);
  for (size_t i = 0; i < n; i++) {
    for (int k = 0; k < 3; k++) {
      ranges[i].axis[k] = load3(axes.data() + 9 * i + 3 * k);
      ranges[i].lower[k] = lower.data()[3 * i + k];
      ranges[i].upper[k] = upper.data()[3 * i + k];
    }
    ranges[i].finish();
  }
  drives[person].ranges = std::move(ranges);
}

namespace {

// Skin points (n,) of a person: two bodies each, their weights, where they are in their frames, and the
// normal in the first's frame.
std::vector<SkinPoint> skin_points(const Stepper& s, Ints body, Doubles weight, Rows3 local,
                                   Rows3 normal) {
  const size_t n = normal.shape(0);
  need(body.shape(0) == 2 * n && weight.shape(0) == 2 * n && local.shape(0) == 2 * n,
       "skin points: arrays of different lengths");
  std::vector<SkinPoint> out(n);
  for (size_t i = 0; i < 2 * n; i++) {
    SkinPoint& p = out[i / 2];
    p.body[i % 2] = body.data()[i];
    need(p.body[i % 2] > 0 && p.body[i % 2] < s.system.model.nbody, "skin points: no such body");
    p.weight[i % 2] = weight.data()[i];
    p.local[i % 2] = load3(local.data() + 3 * i);
    p.normal = load3(normal.data() + 3 * (i / 2));
  }
  return out;
}

}  // namespace

void set_footing(Stepper& s, int person, Faces joints, Ints soles, int hands, Ints body,
                 Doubles weight, Rows3 local, Rows3 normal) {
  const Model& m = s.system.model;
  need(person >= 0 && person < (int)s.system.drives.size() && joints.shape(0) == soles.shape(0),
       "set_footing: bad person or length");
  const Drive& d = s.system.drives[person];
  auto model = std::make_shared<FootingModel>();
  const std::vector<SkinPoint> points = skin_points(s, body, weight, local, normal);
  auto next = points.begin();
  for (size_t f = 0; f < joints.shape(0); f++) {
    Leg leg;
    int* bodies[] = {&leg.hip, &leg.knee, &leg.ankle};
    int* quats[] = {&leg.hip_qpos, &leg.knee_qpos, &leg.ankle_qpos};
    for (int k = 0; k < 3; k++) {
      const int b = joints.data()[3 * f + k];
      need(b > 0 && b < m.nbody && m.plain_ball[b] && m.root[b] == d.body(0),
           "set_footing: no such joint of the person");
      *bodies[k] = b, *quats[k] = m.jnt_qpos[m.jnt_first[b]];
      for (int ball = 0; ball < d.ball_count() && !d.ranges.empty(); ball++)
        if (d.body(ball) == b) leg.ranges.push_back(d.ranges[ball]);
    }
    need(leg.ranges.empty() || leg.ranges.size() == 3, "set_footing: no such joint");
    leg.root = m.parent[leg.hip];
    for (int b = 1; b < m.nbody; b++)
      if (m.parent[b] == leg.ankle) leg.toes = b;
    need(soles.data()[f] > 0 && points.end() - next >= soles.data()[f],
         "set_footing: too few points");
    leg.sole.assign(next, next + soles.data()[f]);
    next += soles.data()[f];
    model->legs.push_back(leg);
  }
  need(!model->legs.empty(), "set_footing: no leg");
  need(hands >= 0 && points.end() - next >= hands, "set_footing: too few points");
  for (const SkinPoint& p : points)
    for (int b : p.body) need(m.root[b] == d.body(0), "set_footing: skin of another person");
  model->skin.assign(next, points.end() - hands);
  model->hands.assign(points.end() - hands, points.end());
  s.system.drives[person].footing.model = model;
}

void set_waiting(Stepper& s, bool on) {
  for (Drive& d : s.system.drives) d.clock.on = on;
}

}  // namespace hp::assembly
