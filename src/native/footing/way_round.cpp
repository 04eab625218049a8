#include "footing/way_round.h"

#include <functional>
#include <queue>
#include <tuple>

#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

namespace {

// How far the middle of a body is from static geometry, somewhere on the ground.
class Room {
 public:
  Room(const CollisionWorld& world, double ground) : world_(world) {
    // What is no higher than a stair is no nearer than it has to be.
    const double low = tune::kStepUp + tune::kBodyRoom + tune::kMiddle;
    middle_.vertices = {{0, 0, ground + low}, {0, 0, ground + tune::kChest - tune::kMiddle}};
    middle_.radius = tune::kMiddle;
    middle_.finish();
  }

  // Up to kRoomy; negative: it is inside.
  double at(Vec3 x) {
    probe_.place(middle_, {}, {x.x, x.y, 0});
    Box3 box = probe_.box();
    box.grow(tune::kRoomy);
    double room = tune::kRoomy;
    for (const Static& s : world_.statics) {
      if (s.kind == Static::Kind::HalfSpace) {
        if (std::fabs(s.n.z) < tune::kSteep) room = std::min(room, probe_.lowest(s.n) - s.offset);
      } else if (s.kind == Static::Kind::Hull) {
        if (box.meets(s.posed.box()))
          room = std::min(room, separate(probe_, s.posed, tune::kRoomy, false).dist);
      } else if (box.meets(s.tree->box())) {
        room = std::min(room, s.tree->distance(probe_, tune::kRoomy));
      }
    }
    return room;
  }

  // What there has to be at `x` for somebody who stands where there is `own` room: who stands at something may
  // leave it.
  double needed(Vec3 from, double own, Vec3 x) const {
    const double dx = x.x - from.x, dy = x.y - from.y;
    const bool leaves = dx * dx + dy * dy < tune::kLeaves * tune::kLeaves;
    return leaves ? std::clamp(own - tune::kSameRoom, 0.0, tune::kBodyRoom) : tune::kBodyRoom;
  }

  // Is there room for a body on all of a straight line?
  bool straight(Vec3 from, Vec3 to) {
    const Vec3 way{to.x - from.x, to.y - from.y, 0};
    const double length = norm(way);
    if (!(length < tune::kFarthest)) return true;
    const int n = (int)std::ceil(length / tune::kLook);
    const double own = at(from);
    for (int i = 1; i <= n; i++) {
      const Vec3 x = from + ((double)i / n) * way;
      if (at(x) < needed(from, own, x)) return false;
    }
    return true;
  }

 private:
  const CollisionWorld& world_;
  Convex middle_;
  PosedShape probe_;
};

// The search on a grid whose middle is half-way between the ends.
class Search {
 public:
  Search(Room& room, Vec3 from, Vec3 to)
      : room_(room), from_(from), cost_(kCells, -1), room_at_(kCells, -1e300), before_(kCells, -1) {
    origin_ = 0.5 * (from + to);
    own_ = room.at(from);
    goal_ = clamped(to);
  }

  // Cells from the one after the start to the goal, or to what is nearest to it.
  std::vector<Vec3> run() {
    const int start = clamped(from_);
    int nearest = start;
    cost_[start] = 0;
    open_.push({to_go(start), start, 0});
    std::vector<char> done(kCells, 0);
    for (int steps = 0; !open_.empty() && steps < tune::kMostCells;) {
      const int cell = std::get<1>(open_.top());
      open_.pop();
      if (done[cell]) continue;
      done[cell] = 1;
      steps++;
      if (to_go(cell) < to_go(nearest)) nearest = cell;
      if (cell == goal_) break;
      expand(cell);
    }
    std::vector<Vec3> way;
    for (int c = nearest; c != start; c = before_[c]) way.push_back(at(c));
    std::reverse(way.begin(), way.end());
    return way;
  }

 private:
  static constexpr int kSide = 2 * tune::kHalfGrid + 1, kCells = kSide * kSide;
  using Open = std::tuple<double, int, double>;  // cost with what is to go, cell, cost

  int clamped(Vec3 x) const {
    const auto index = [](double d) {
      return std::clamp((int)std::lround(d / tune::kCell), -tune::kHalfGrid, tune::kHalfGrid) +
             tune::kHalfGrid;
    };
    return index(x.y - origin_.y) * kSide + index(x.x - origin_.x);
  }
  Vec3 at(int cell) const {
    return {origin_.x + (cell % kSide - tune::kHalfGrid) * tune::kCell,
            origin_.y + (cell / kSide - tune::kHalfGrid) * tune::kCell, 0};
  }
  double to_go(int cell) const { return norm(at(cell) - at(goal_)); }
  double room(int cell) {
    if (room_at_[cell] < -1e299) room_at_[cell] = std::max(room_.at(at(cell)), -1e299);
    return room_at_[cell];
  }

  void expand(int cell) {
    const int x = cell % kSide, y = cell / kSide;
    for (int dy = -1; dy <= 1; dy++)
      for (int dx = -1; dx <= 1; dx++) {
        if ((dx == 0 && dy == 0) || x + dx < 0 || x + dx >= kSide || y + dy < 0 || y + dy >= kSide)
          continue;
        const int next = cell + dy * kSide + dx;
        const double free = room(next);
        if (free < room_.needed(from_, own_, at(next))) continue;
        const double length = tune::kCell * std::sqrt((double)(dx * dx + dy * dy));
        const double narrow = std::max(0.0, 1 - free / tune::kRoomy);
        const double cost = cost_[cell] + length * (1 + tune::kNarrow * narrow);
        if (cost_[next] >= 0 && cost_[next] <= cost) continue;
        cost_[next] = cost;
        before_[next] = cell;
        open_.push({cost + to_go(next), next, cost});
      }
  }

  Room& room_;
  Vec3 from_, origin_;
  int goal_ = 0;
  double own_ = 0;                      // room at the start [m]
  std::vector<double> cost_, room_at_;  // per cell; -1: not reached, -1e300: not known
  std::vector<int> before_;
  std::priority_queue<Open, std::vector<Open>, std::greater<Open>> open_;
};

}  // namespace

void WayRound::clear() {
  way_.clear();
  to_ = {};
  age_ = 0;
  on_ = false;
}

void WayRound::find(const CollisionWorld& world, Vec3 from, Vec3 to, double ground) {
  Room room(world, ground);
  way_.clear();
  to_ = to, age_ = 0;
  on_ = !room.straight(from, to);
  if (!on_) return;
  way_ = Search(room, from, to).run();
  // The farthest point in sight.
  size_t seen = 0;
  while (seen + 1 < way_.size() && room.straight(from, way_[seen + 1])) seen++;
  if (!way_.empty()) way_.erase(way_.begin(), way_.begin() + (long)seen);
}

Vec3 WayRound::next(const CollisionWorld& world, Vec3 from, Vec3 to, double ground, double dt) {
  from.z = to.z = 0;
  age_ += dt;
  if (!on_ || age_ > tune::kFindsAnew || norm(to - to_) > tune::kMovedOn)
    find(world, from, to, ground);
  if (!on_) return to;
  while (!way_.empty() && norm(way_.front() - from) < tune::kReached) way_.erase(way_.begin());
  return way_.empty() ? from : way_.front();
}

void WayRound::save(std::vector<double>& out) const {
  out.insert(out.end(), {(double)way_.size(), to_.x, to_.y, age_, on_ ? 1.0 : 0.0});
  for (Vec3 x : way_) out.insert(out.end(), {x.x, x.y});
}

const double* WayRound::load(const double* in) {
  way_.resize((size_t)in[0]);
  to_ = {in[1], in[2], 0};
  age_ = in[3], on_ = in[4] != 0;
  in += 5;
  for (Vec3& x : way_) x = {in[0], in[1], 0}, in += 2;
  return in;
}

}  // namespace hp
