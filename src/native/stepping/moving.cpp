// Things whose velocity is given, on a track, and things asleep until something touches them.
//
// To contacts what is on a track is as heavy as can be: its velocity enters v_n, and no impulse changes
// it. What else a step is, shortened steps included, holds for it as for all others. What sleeps has
// its mass and no gravity; the first impulse on it wakes it, and the step is made again.
#include <stdexcept>

#include "stepping/stepper.h"

namespace hp {

namespace {

// What lies as near as this many clearances to something that wakes, wakes too.
constexpr double kLiesOn = 2;
// What squeezes somebody goes so much slower in the next try, no slower than the second of these (then
// it stands), and so much faster in every substep after that; what stands tries again after so many
// substeps at most.
constexpr double kSlowDown = 0.25, kLeastPace = 1.0 / 16, kFaster = 2;
constexpr int kMostPatience = 32;

}  // namespace

void Track::at(double time, Vec3& p, Quat& q) const {
  const int n = (int)position.size();
  double frame = time * fps;
  if (loop) frame -= n * std::floor(frame / n);
  // What is a rounding away from a pose is at it.
  if (std::fabs(frame - std::round(frame)) < 1e-9) frame = std::round(frame);
  int i = (int)std::floor(frame), j = i + 1;
  double share = frame - i;
  if (loop) {
    i %= n, j %= n;
  } else if (j > n - 1) {
    i = j = n - 1, share = 0;
  }
  p = position[i] + share * (position[j] - position[i]);
  q = share == 0 ? turn[i] : turn[i] * exp_quat(share * log_quat(conjugate(turn[i]) * turn[j]));
}

void Stepper::add_track(Track track) {
  const bool free = track.body > 0 && track.body < model.nbody && model.jnt_count[track.body] == 1 &&
                    model.jnt_type[model.jnt_first[track.body]] == Joint::Free;
  if (!free || track.position.empty() || track.turn.size() != track.position.size())
    throw std::invalid_argument("add_track: bad track");
  tracks_.push_back(std::move(track));
}

void Stepper::start_asleep(int body) {
  if (body <= 0 || body >= model.nbody) throw std::invalid_argument("start_asleep: no such body");
  start_asleep_.push_back(body);
}

// What sleeps stands still; what is on a track goes to where that has it after the substep.
void Stepper::given_velocity(double h) {
  for (int b : objects_)
    if (world.asleep[b] && world.active[b])
      for (int i = model.dof_first[b]; i < model.dof_first[b] + 6; i++) v_free_[i] = spin_[i] = 0;
  for (size_t i = 0; i < tracks_.size(); i++) {
    const Track& t = tracks_[i];
    const int q = model.jnt_qpos[model.jnt_first[t.body]], d = model.dof_first[t.body];
    Vec3 p;
    Quat turn;
    t.at(clock_[i] + pace_[i].share * h, p, turn);
    store3(&v_free_[d], (1 / h) * (p - load3(&qpos_[q])));
    store3(&v_free_[d + 3], (1 / h) * log_quat(conjugate(load4(&qpos_[q + 3])) * turn));
    store3(&spin_[d + 3], {});
  }
}

// A track goes on where its thing was stopped: what blocks it delays it.
// Returns the most that one has lost.
double Stepper::pass_time(double h) {
  double most = 0;
  for (size_t i = 0; i < tracks_.size(); i++) {
    const double on = pace_[i].share * (h - behind_[tracks_[i].body]);
    clock_[i] += on;
    most = std::max(most, h - on);
  }
  behind_.assign(model.nbody, 0);
  return most;
}

// A thing that was slowed down picks up speed again; one that stands tries now and then.
void Stepper::set_pace() {
  for (Pace& p : pace_) {
    if (p.share > 0) {
      p.share = std::min(1.0, kFaster * p.share);
      if (p.share == 1) p.patience = 0;
    } else if (--p.wait <= 0) {
      p.share = kLeastPace;
    }
  }
}

// Who is squeezed gets no clearance back: that would take room on both sides.
void Stepper::squeeze() {
  bool islands = false;
  for (size_t i = 0; i < tracks_.size(); i++) {
    if (pace_[i].share == 1 || !world.active[tracks_[i].body]) continue;
    if (!islands) find_islands();
    islands = true;
    for (int b = 1; b < model.nbody; b++)
      if (island_[model.root[b]] == island_[tracks_[i].body]) gave_way_[b] = 1;
  }
}

// Of all that takes part and can be pushed [kg], where anything is on a track; else 0.
double Stepper::moving_mass() const {
  double mass = 0;
  for (int b = 1; b < model.nbody && !tracks_.empty(); b++)
    if (world.active[b] && !model.held[model.root[b]]) mass += model.mass[b];
  return mass;
}

// Nor does friction hold them: where everything is wedged it has no answer, or many.
void Stepper::slip_out() {
  bool any = false;
  for (const Pace& p : pace_) any |= p.share < 1;
  if (!any) return;
  for (Contact& c : contacts_) {
    const int a = tree(candidates_[c.pair].shape);
    if (person_[a] && gave_way_[a]) c.friction = 0;
  }
}

// Where the contacts of a step cannot be solved because something on a track leaves no room, that goes
// slower, or stands, and everybody else makes the step. False if nothing is to be slowed down.
bool Stepper::slow_down(double h) {
  bool slow = false;
  for (const Pace& p : pace_) slow |= p.share < 1;
  if (good_ || tracks_.empty() || !(crushed_ || slow)) return false;
  find_islands();
  std::vector<char> squeezed(model.nbody, 0);
  for (size_t i = 0; i < candidates_.size() && i < violated_.size(); i++)
    if (violated_[i]) squeezed[island(candidates_[i])] = 1;
  bool any = false;
  for (size_t i = 0; i < tracks_.size(); i++) {
    Pace& p = pace_[i];
    if (p.share == 0 || !squeezed[island_[tracks_[i].body]]) continue;
    any = true;
    p.share = p.share > kLeastPace ? std::max(kLeastPace, kSlowDown * p.share) : 0;
    if (p.share > 0) continue;
    p.patience = std::min(kMostPatience, std::max(1, 2 * p.patience));
    p.wait = p.patience;
  }
  if (any) given_velocity(h);
  return any;
}

void Stepper::wake(int body) {
  world.asleep[body] = 0;
}

// Wakes what the last solve found touched, and what lies on that. True if there was anything.
bool Stepper::wake_touched() {
  std::vector<char> woken(model.nbody, 0);
  bool any = false;
  auto up = [&](int shape) {
    if (shape < 0 || !world.asleep[tree(shape)]) return;
    wake(tree(shape));
    woken[tree(shape)] = 1;
    any = true;
  };
  for (const Contact& c : contacts_) {
    if (dot(c.impulse, c.n) <= 0) continue;
    up(candidates_[c.pair].shape);
    up(candidates_[c.pair].other_shape);
  }
  if (!any) return false;
  const double range = kLiesOn * world.settings.clearance;
  for (bool more = true; more;) {
    more = false;
    for (int i = 0; i < (int)world.shapes.size(); i++)
      for (int j = 0; j < (int)world.shapes.size() && world.asleep[tree(i)]; j++) {
        if (!woken[tree(j)] || world.pairing(world.shapes[i].name, world.shapes[j].name).ignore)
          continue;
        if (separate(world.place(start_, i), world.place(start_, j), range).dist >= range) continue;
        up(i);
        more = true;
      }
  }
  object_velocity(step_, &woken);
  return true;
}

// A step of length h, in which what is touched is free from the beginning.
void Stepper::attempt(double h) {
  do push_out(h);
  while (wake_touched());
}

void Stepper::set_velocity(int body, const double* six) {
  if (body <= 0 || body >= model.nbody || model.dof_count[body] != 6)
    throw std::invalid_argument("set_velocity: no such body");
  qvel();
  std::copy_n(six, 6, &qvel_[model.dof_first[body]]);
  wake(body);
}

void World::adopt(const World& old, const std::vector<int>& shape) {
  std::vector<int> now(old.shapes.size(), -1);  // the other way round
  for (int i = 0; i < (int)shape.size(); i++)
    if (shape[i] >= 0) now[shape[i]] = i;
  auto known = [&](const ContactCandidate& c) {
    return shape[c.shape] >= 0 && (c.other_shape < 0 || shape[c.other_shape] >= 0);
  };
  auto renamed = [&](auto& c) {
    c.shape = now[c.shape];
    if (c.other_shape >= 0) c.other_shape = now[c.other_shape];
    return c.shape >= 0 && (c.other_static >= 0 || c.other_shape >= 0);
  };
  for (auto it = pairs_.begin(); it != pairs_.end();)
    it = known(unpacked(it->first)) ? pairs_.erase(it) : std::next(it);
  for (const auto& [k, state] : old.pairs_) {
    ContactCandidate c = unpacked(k);
    if (renamed(c)) pairs_[key(c)] = state;
  }
  std::vector<Inside> in;
  for (Inside i : old.inside_)
    if (renamed(i)) in.push_back(i);
  for (const Inside& i : inside_)
    if (shape[i.shape] < 0 || (i.other_shape >= 0 && shape[i.other_shape] < 0)) in.push_back(i);
  inside_ = in;
  growth = old.growth;
  has_list_ = false;
}

void Stepper::adopt(Stepper& old, const std::vector<int>& body, const std::vector<int>& shape) {
  if ((int)body.size() != model.nbody || shape.size() != world.shapes.size() ||
      drives_.size() != old.drives_.size())
    throw std::invalid_argument("adopt: not the same people");
  old.qvel();
  for (int b = 1; b < model.nbody; b++) {
    const int was = body[b];
    if (was < 0) continue;
    std::copy_n(&old.qvel_[old.model.dof_first[was]], model.dof_count[b],
                &qvel_[model.dof_first[b]]);
    world.asleep[b] = old.world.asleep[was];
    way_out_[b] = old.way_out_[was];
  }
  for (size_t p = 0; p < drives_.size(); p++) {
    std::vector<double> state;
    old.drives_[p].save(state);
    drives_[p].load(state.data());
    if (drives_[p].gentle()) drives_[p].go_gently(kGentle, joint_reach_);
  }
  for (size_t i = 0; i < tracks_.size(); i++)
    for (size_t k = 0; k < old.tracks_.size(); k++)
      if (body[tracks_[i].body] == old.tracks_[k].body)
        clock_[i] = old.clock_[k], pace_[i] = old.pace_[k];
  world.adopt(old.world, shape);
  // What is new may be inside somebody.
  for (const Inside& in : world.inside())
    for (int b = world.shapes[in.shape].body; b > 0 && !way_out_[b]; b = model.parent[b])
      way_out_[b] = 1;
  for (Drive& d : drives_)
    if (comes_out(d) && !d.gentle()) d.go_gently(kGentle, joint_reach_);
  warm_.clear();
  std::vector<int> now(old.world.shapes.size(), -1);
  for (int i = 0; i < (int)shape.size(); i++)
    if (shape[i] >= 0) now[shape[i]] = i;
  for (CachedContact w : old.warm_) {
    const int a = now[(int)(w.key >> 32)];
    int other = (int)(w.key & 0xffffffff);
    if (other % 2 == 1) other = now[other / 2] < 0 ? -1 : 2 * now[other / 2] + 1;
    if (a < 0 || other < 0) continue;
    w.key = ((int64_t)a << 32) | (int64_t)other;
    warm_.push_back(w);
  }
}

}  // namespace hp
