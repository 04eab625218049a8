// People whose poses are set: what half-physics is compared with (docs/physics.md, "Baselines").
//
// To contacts they are trees that stand, as heavy as can be, and that nobody moves: a body that is put
// somewhere has no velocity there. Nothing that stands and nobody else is in their way. What things they
// overlap is found anew wherever they are put, hull by hull, and leaves along the direction of least overlap
// at Settings.depenetration_speed at most; where things have no room they stay overlapped.
#include "stepping/stepper.h"

namespace hp {

namespace {

// Nothing is thrown by what it leaves faster than so many times the speed asked, or than it is and that, at right
// angles; it then leaves so much more slowly, by so many tries, and gains speed again by this factor a substep.
constexpr double kThrown = 3, kAcross = 1.01, kGentler = 0.9, kLeast = 0.1, kNoRoom = 0.3, kRegain = 2;
constexpr int kTries = 3;
// Who would have to leave faster than that to follow two ways out at once, the cosine between them being less
// than 2 / kThrown^2 - 1, does not leave.
constexpr double kOpposed = 2 / (kThrown * kThrown) - 1;
// What has no room is not pushed for so long [s].
constexpr double kPatience = 1.0 / 120, kMostPatience = 0.25;

}  // namespace

void Drive::put(double share, double* qpos) const {
  double* q = qpos + qpos0_;
  if (share >= 1) {
    std::copy(target_.begin(), target_.end(), q);
    return;
  }
  const Vec3 from = load3(previous_.data()), to = load3(target_.data());
  store3(q, from + share * (to - from));
  for (const Ball& b : balls_) {
    const Quat begin = load4(&previous_[b.qpos]), end = load4(&target_[b.qpos]);
    store4(q + b.qpos, normalized(begin * exp_quat(share * log_quat(conjugate(begin) * end))));
  }
}

void World::people_put() {
  exits_known_ = false;
  for (auto it = pairs_.begin(); it != pairs_.end();)
    it = shapes[unpacked(it->first).shape].person >= 0 ? pairs_.erase(it) : std::next(it);
}

// All hulls of a person that are neighbours in the skeleton and overlap one thing leave it along one direction:
// that along which the deepest of them is least deep. Hull by hull the ways would work against each other, and
// what is between them would be thrown.
void World::find_exits(const Model& m, Poses& start) {
  exits_known_ = true;
  struct Pair {
    int shape, other, group;
  };
  std::vector<Pair> in;
  for (const BroadPhasePair& e : broad_pairs_) {
    if (e.other_shape < 0 || shapes[e.shape].person < 0 || !takes_part(e)) continue;
    const PosedShape &a = place(start, e.shape), &b = place(start, e.other_shape);
    if (a.box.meets(b.box) && separate(a, b, 0, false).dist < 0) in.push_back({e.shape, e.other_shape, -1});
  }
  auto body = [&](int shape) { return shapes[shape].body; };
  auto neighbours = [&](int a, int b) { return a == b || m.parent[a] == b || m.parent[b] == a; };
  struct Way {
    int thing;
    Vec3 exit;
  };
  std::vector<Way> found;
  squeezed.assign(m.nbody, 0);
  std::vector<Vec3> ways;
  std::vector<size_t> mine;
  for (size_t first = 0; first < in.size(); first++) {
    if (in[first].group >= 0) continue;
    mine.assign(1, first);
    in[first].group = (int)first;
    for (size_t k = 0; k < mine.size(); k++)
      for (size_t i = first + 1; i < in.size(); i++) {
        const Pair& known = in[mine[k]];
        if (in[i].group >= 0 || body(in[i].other) != body(known.other) ||
            !neighbours(body(in[i].shape), body(known.shape)))
          continue;
        in[i].group = (int)first;
        mine.push_back(i);
      }
    ways.clear();
    for (size_t i : mine) {
      const PosedShape &a = place(start, in[i].shape), &b = place(start, in[i].other);
      ways.push_back(separate(a, b).n);
      for (Vec3 n : b.shape->normals) ways.push_back(-(b.R * n));
    }
    for (int k = 0; k < 27; k++) {
      const Vec3 n{(double)(k % 3 - 1), (double)(k / 3 % 3 - 1), (double)(k / 9 - 1)};
      if (k != 13) ways.push_back((1 / norm(n)) * n);
    }
    Vec3 exit;
    double least = -1e300;
    for (Vec3 n : ways) {
      double dist = 0;
      for (size_t i : mine) {
        dist = std::min(dist, separate_along(place(start, in[i].shape), place(start, in[i].other), n).dist);
        if (dist <= least) break;
      }
      if (dist > least) least = dist, exit = n;
    }
    const int thing = body(in[first].other);
    for (const Way& w : found)
      if (w.thing == thing && dot(w.exit, exit) < kOpposed) squeezed[thing] = 1;
    found.push_back({thing, exit});
    for (size_t i : mine) {
      ContactCandidate c;
      c.shape = in[i].shape, c.other_shape = in[i].other;
      pairs_[key(c)] = {settings.clearance, true, exit};
    }
  }
}

// All but people take part in steps; these stand in their way, or are not there.
void Stepper::leave_people() {
  for (int b = 1; b < model.nbody; b++) {
    world.active[b] = !is_person(b);
    world.standing[b] = is_person(b) && forced != Forced::Kinematic;
    if (is_person(b)) model.held[b] = 1;
  }
}

// Puts everybody at a share of the frame's way.
void Stepper::put_people(double share) {
  for (const Drive& d : drives_) d.put(share, qpos_.data());
  end_.kin.update(model, qpos_.data());
  world.start_poses(end_);
  for (int b = 1; b < model.nbody; b++) world.active[b] = is_person(b);
  ways(world.shapes, start_, end_, world.active, way_);
  world.travel(way_, {});
  world.people_put();
  // A step moves what takes part, from one of the two to the other: all else is in both.
  start_.kin = end_.kin;
  world.start_poses(start_);
  leave_people();
}

// The fastest point of a thing, at most [m/s].
double Stepper::fastest(int body, const std::vector<Twist>& twists) const {
  double most = 0;
  for (const CollisionShape& m : world.shapes)
    if (m.body == body) most = std::max(most, speed_bound(m, twists));
  return most;
}

// What had no room is not pushed for a while; what was pushed more gently picks up speed.
void Stepper::set_push(double h) {
  for (int b = 1; b < model.nbody; b++) {
    Push& p = push_[b];
    p.wait = std::max(0.0, p.wait - h);
    double& pace = world.pace[b];
    pace = p.wait > 0 ? 0 : pace == 0 ? 1 : std::min(1.0, kRegain * pace);
  }
}

// A thing stays where it is in this substep, whatever touches it.
void Stepper::jam(int tree) {
  for (int b = tree; b < model.nbody; b++) {
    if (model.root[b] != tree) continue;
    jammed_.push_back(b);
    model.held[b] = 1;
    for (int i = model.dof_first[b]; i < model.dof_first[b] + model.dof_count[b]; i++)
      v_free_[i] = spin_[i] = 0;
  }
}

// A step of length h. A thing that people are inside of leaves them more slowly where it would be thrown, and not
// at all where it has no room; what is thrown even so is jammed and stays where it is.
void Stepper::push_out(double h) {
  if (forced == Forced::No) return emerge(h);
  for (int tries = 0;; tries++) {
    emerge(h);
    std::vector<char> inside(model.nbody, 0), forget(model.nbody, 0);
    for (const ContactCandidate& c : candidates_)
      if (c.dist < 0 && c.other_shape >= 0 && is_person(world.shapes[c.shape].body))
        inside[world.shapes[c.other_shape].body] = 1;
    std::vector<Twist> free;
    body_twists(model, start_.kin, v_.data(), twists_);
    body_twists(model, start_.kin, v_free_.data(), free);
    bool again = false;
    for (int b = 1; b < model.nbody; b++) {
      if (!inside[b]) push_[b].patience = 0;
      if (!inside[b] || model.held[b]) continue;
      double& pace = world.pace[b];
      if (world.squeezed[b]) pace = 0;
      const double pushed = world.settings.depenetration_speed, speed = fastest(b, twists_),
                   most = std::max(kThrown * pushed, kAcross * std::hypot(fastest(b, free), pushed));
      const bool room = good_ && !gave_way_[model.root[b]];
      if (speed <= most && (room || pace == 0)) continue;
      if (pace == 0) {
        jam(model.root[b]);
      } else if (tries < kTries) {
        pace *= room ? std::max(kLeast, kGentler * most / speed) : kNoRoom;
      } else {
        Push& p = push_[b];
        p.wait = p.patience = std::min(kMostPatience, std::max(kPatience, 2 * p.patience));
        pace = 0;
      }
      forget[model.root[b]] = 1;
      again = true;
    }
    if (!again) break;
    // What pressed on it without an end is no guess of what presses now.
    auto forgotten = [&](const CachedContact& w) {
      const int other = (int)(w.key & 0xffffffff);
      return forget[tree((int)(w.key >> 32))] || (other % 2 == 1 && forget[tree(other / 2)]);
    };
    warm_.erase(std::remove_if(warm_.begin(), warm_.end(), forgotten), warm_.end());
  }
  for (int b : jammed_) model.held[b] = 0;
  jammed_.clear();
}

void Stepper::force_frame(const double* targets, double dt, int n, std::vector<double>* poses) {
  touches_.clear();
  diagnostics_ = {};
  disturbed_.assign(model.nbody, 0);
  start_pose();
  for (Drive& d : drives_) {
    d.aim(drive_settings, targets, dt, qpos_.data());
    targets += d.qpos_count();
    std::fill_n(qvel_.begin() + d.first_dof(), d.dof_count(), 0.0);
  }
  record_ = nullptr;
  bool things = false;
  for (int b = 1; b < model.nbody; b++) things |= !is_person(b);
  for (int k = 0; k < n; k++) {
    if (forced == Forced::Interpolated)
      put_people((k + 1.0) / n);
    else if (k == 0)
      put_people(1);
    const int parts = parts_of(dt / n);
    for (int i = 0; i < parts && things; i++) {
      set_push(dt / n / parts);
      substep(k * parts + i, dt / n / parts);
    }
    if (poses) poses->insert(poses->end(), qpos_.begin(), qpos_.end());
  }
  world.active.assign(model.nbody, 1);
}

}  // namespace hp
