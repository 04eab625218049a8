#include "stepping/joint_ranges.h"

#include <algorithm>
#include <cmath>

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

namespace {

Quat rotation(const Drive& d, int ball, const std::vector<double>& qpos) {
  return load4(&qpos[d.first_qpos() + d.balls()[ball].qpos]);
}

// Angles of q, the twist counted as the nearest to `about`.
Vec3 angles_near(const JointRange& range, Quat q, double about) {
  Vec3 a = joint_angles(range, q);
  a.x += 2 * M_PI * std::round((about - a.x) / (2 * M_PI));
  return a;
}

// How far a row's joint is off its end at a pose [rad].
double row_gap(const System& system, const RangeRow& row, const std::vector<double>& qpos) {
  const Drive& d = system.drives[row.person];
  const Vec3 at = angles_near(d.ranges[row.ball], rotation(d, row.ball, qpos), row.about);
  return row.sign * (at[row.axis] - row.limit);
}

}  // namespace

void JointRanges::begin(const System& system, Data& data, double h) {
  h_ = h;
  data.attempt.ranges.clear();
  data.step.yielded = data.step.yielded_before;
  windows_.resize(system.drives.size());
  for (size_t p = 0; p < windows_.size(); p++) {
    windows_[p].resize(system.drives[p].ranges.size());
    for (Window& w : windows_[p]) w.known = false;
  }
}

// The range, and what the motion asks at the start and the end of the substep.
const JointRanges::Window& JointRanges::window(const System& system, const Data& data, int person,
                                               int ball) {
  Window& w = windows_[person][ball];
  if (w.known) return w;
  w.known = true;
  const Drive& d = system.drives[person];
  const JointRange& range = d.ranges[ball];
  const double share = data.step.length / d.motion.frame_length();
  w.about = 0;
  for (int i = 0; i < 3; i++) w.lower[i] = range.lower[i], w.upper[i] = range.upper[i];
  for (const int k : {data.step.index + 1, data.step.index}) {
    const Quat q = d.motion.at(d.balls()[ball], std::min(1.0, k * share));
    const Vec3 asked = angles_near(range, q, w.about);
    if (k == data.step.index + 1) w.about = asked.x;
    for (int i = 0; i < 3; i++) {
      w.lower[i] = std::min(w.lower[i], asked[i]);
      w.upper[i] = std::max(w.upper[i], asked[i]);
    }
  }
  return w;
}

void JointRanges::check(const System& system, Data& data, double h) {
  Attempt& attempt = data.attempt;
  for (RangeRow& row : attempt.ranges)
    if (attempt.islands[data.islands.of_limit(system, row.contact)].open())
      correct(system, data, row, h);
  for (size_t p = 0; p < system.drives.size(); p++) {
    const Drive& d = system.drives[p];
    if (d.ranges.empty() || !system.active(d) || d.gentle() || gone(system, data, (int)p)) continue;
    const IslandProgress& progress = attempt.islands[data.islands.of_tree(d.body(0))];
    if (!progress.open() || progress.ranges_known || progress.pass >= tune::kRangePasses) continue;
    for (int ball = 1; ball < d.ball_count(); ball++)
      if (!d.ranges[ball].holds(rotation(d, ball, data.step.end_qpos)))
        check_ball(system, data, (int)p, ball, h);
  }
}

void JointRanges::check_ball(const System& system, Data& data, int person, int ball, double h) {
  Attempt& attempt = data.attempt;
  const Drive& d = system.drives[person];
  const JointRange& range = d.ranges[ball];
  const Window& w = window(system, data, person, ball);
  const Quat start = rotation(d, ball, data.state.qpos),
             end = rotation(d, ball, data.step.end_qpos);
  const Vec3 from = angles_near(range, start, w.about), to = angles_near(range, end, w.about);
  for (int axis = 0; axis < 3; axis++) {
    if (axis == 0 && !(has_twist(range, start) && has_twist(range, end))) continue;
    for (const double sign : {1.0, -1.0}) {
      RangeRow row;
      row.person = person, row.ball = ball, row.axis = axis, row.sign = sign;
      row.limit = sign > 0 ? w.lower[axis] : w.upper[axis];
      row.about = w.about;
      row.contact.dist = tune::kRangeLever * sign * (from[axis] - row.limit);
      row.contact.target = target(system, data, row);
      const double gap_end = tune::kRangeLever * sign * (to[axis] - row.limit);
      if (gap_end >= row.contact.target - tune::kRangeLever * tune::kRangeRounding) continue;
      if (gap_end < row.contact.target - tune::kRangeLever * tune::kRangeSlack)
        attempt.islands[data.islands.of_tree(d.body(0))].violated = true;
      const auto same = [&](const RangeRow& r) {
        return r.person == person && r.ball == ball && r.axis == axis && r.sign == sign;
      };
      if (std::any_of(attempt.ranges.begin(), attempt.ranges.end(), same)) continue;
      row.rates = std::make_shared<std::vector<Endpoint::Bend>>(3);
      row.contact.a.bends = row.rates;
      row.contact.n = {1, 0, 0}, row.contact.t = {0, 1, 0}, row.contact.s = {0, 0, 1};
      correct(system, data, row, h);
      attempt.ranges.push_back(row);
    }
  }
}

// Makes a row linear at the middle of the way that step.v takes the joint, and exact at its end.
void JointRanges::correct(const System& system, const Data& data, RangeRow& row, double h) {
  const Drive& d = system.drives[row.person];
  const JointRange& range = d.ranges[row.ball];
  const int dof = d.ball_dof(row.ball);
  const Vec3 omega = load3(&data.step.v[dof]);
  row.at = normalized(rotation(d, row.ball, data.state.qpos) * exp_quat((0.5 * h) * omega));
  Vec3 rates[3];
  joint_angle_rates(range, row.at, rates);
  const Vec3 rate = (row.sign * tune::kRangeLever) * rates[row.axis];
  for (int i = 0; i < 3; i++) (*row.rates)[i] = {dof + i, {rate[i], 0, 0}};
  const double gap_end = tune::kRangeLever * row_gap(system, row, data.step.end_qpos);
  const double miss = row.contact.dist + h * dot(rate, omega) - gap_end;
  const double room = std::max(0.0, row.contact.dist - row.contact.target);
  row.contact.shift = std::min(miss, room + tune::kRangeLever * h * tune::kMostRangeCorrection);
}

bool JointRanges::any(const System& system, const Data& data, int island) {
  const std::vector<RangeRow>& rows = data.attempt.ranges;
  return std::any_of(rows.begin(), rows.end(), [&](const RangeRow& r) {
    return data.islands.of_limit(system, r.contact) == island;
  });
}

bool JointRanges::hold_fast(const System& system, Data& data, int island) {
  IslandProgress& progress = data.attempt.islands[island];
  if (progress.ranges_known || !any(system, data, island)) return false;
  return progress.ranges_known = true;
}

bool JointRanges::give_way(const System& system, Data& data, int island) {
  IslandProgress& progress = data.attempt.islands[island];
  if (progress.ranges_gave || !any(system, data, island)) return false;
  progress.ranges_gave = true;
  std::vector<RangeRow>& rows = data.attempt.ranges;
  yield(system, data, island);
  size_t kept = 0;
  for (RangeRow& r : rows) {
    const bool own = data.islands.of_limit(system, r.contact) == island;
    if (own && gone(system, data, r.person)) continue;
    if (own) r.contact.target = target(system, data, r);
    rows[kept++] = r;
  }
  rows.resize(kept);
  return true;
}

void JointRanges::yield(const System& system, Data& data, int island) {
  for (const Drive& d : system.drives) {
    if (d.ranges.empty() || data.islands.of_tree(d.body(0)) != island) continue;
    int& level = data.step.yielded[d.body(0)];
    level = std::min(level + 1, tune::kRangeLevels);
  }
}

bool JointRanges::gone(const System& system, const Data& data, int person) {
  return data.step.yielded[system.drives[person].body(0)] == tune::kRangeLevels;
}

// How far rows of this person may be missed in this step [rad].
double JointRanges::give(const System& system, const Data& data, int person) const {
  const int level = data.step.yielded[system.drives[person].body(0)];
  return level == tune::kRangeLevels ? 0 : tune::kRangeGive[level] * h_ / data.step.length;
}

// What a row demands: the end of the range, or from beyond it a way back; less where ranges give way.
double JointRanges::target(const System& system, const Data& data, const RangeRow& row) const {
  const double gap = row.contact.dist / tune::kRangeLever;
  const double less = give(system, data, row.person);
  return tune::kRangeLever * std::min(gap + (less > 0 ? 0 : h_ * tune::kRangeReturn), 0.0) -
         tune::kRangeLever * less;
}

void JointRanges::end(const System& system, Data& data) {
  for (size_t i = 0; i < data.attempt.ranges.size(); i++) {
    const RangeRow& row = data.attempt.ranges[i];
    const int island = data.islands.of_limit(system, row.contact);
    IslandProgress& progress = data.attempt.islands[island];
    if (progress.state != IslandProgress::State::Settled || holds(system, data, row)) continue;
    progress.state = IslandProgress::State::Stuck;
    yield(system, data, island);
  }
}

bool JointRanges::holds(const System& system, const Data& data, const RangeRow& row) {
  const double from = std::min(row.contact.dist / tune::kRangeLever, 0.0);
  const double target = std::min(from, row.contact.target / tune::kRangeLever);
  return row_gap(system, row, data.step.end_qpos) >= target - tune::kRangeMiss;
}

}  // namespace hp
