#include "footing/footwork.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

namespace {

// A path of least jerk from 0 to 1.
double least_jerk(double s) { return s * s * s * (10 - 15 * s + 6 * s * s); }

}  // namespace

void Footwork::clear(size_t feet) {
  places_.assign(feet, {});
  speed_ = {};
  spin_ = time_ = lasts_ = 0;
  steps_ = landed_ = -1;
  share_ = 1;
  to_ = {};
}

// Where a step is to end: ahead of the body by half of what the foot will be left behind.
Vec3 Footwork::wanted(const Place& place) const {
  return place.home + capped(0.5 * tune::kStance * speed_, tune::kMostAhead);
}

// How far a foot is from where it should be, in steps.
double Footwork::late(const Place& place) const {
  const bool moves =
      place.held || norm(speed_) > tune::kTidySpeed || std::fabs(spin_) > tune::kTidySpin;
  const double far = norm(place.offset - wanted(place)), turn = std::fabs(place.turn);
  return std::max(far / (moves ? tune::kStepAt : tune::kTidyAt),
                  turn / (moves ? tune::kStepTurn : tune::kTidyTurn));
}

// How far a foot may be from its home.
double Footwork::most(const Place& place) {
  return place.held ? tune::kMostStride : tune::kMostBehind;
}

void Footwork::begin_step(const std::vector<Foot>& feet, const Lands& lands) {
  int next = -1;
  double latest = 1;
  for (size_t f = 0; f < feet.size(); f++) {
    const double stood = feet[f].held ? tune::kStoodToWait : tune::kStood;
    if (feet[f].rests <= tune::kAtRestShare || !feet[f].grounded || feet[f].rested < stood) return;
    const double how = late(places_[f]);
    const bool ready = feet[f].stands || hangs(feet[f], places_[f]);
    if (how <= 1 || !ready || !others_stand(feet, f)) continue;
    // Of two that are as late as each other, but for rounding, the one that has stood for longer.
    const bool alike = next >= 0 && std::fabs(how - latest) < tune::kAlikeLate;
    if (alike ? feet[f].rested > feet[next].rested : how > latest) latest = how, next = (int)f;
  }
  if (next < 0) return;
  const Vec3 from = places_[next].offset, to = wanted(places_[next]);
  for (share_ = 1; share_ > 0; share_ -= tune::kShorter)
    if (lands((size_t)next, from + share_ * (to - from), (1 - share_) * places_[next].turn)) break;
  if (share_ <= 0) return;
  steps_ = next;
  time_ = 0;
  lasts_ = std::max(tune::kStepTime - tune::kHurry * norm(speed_), tune::kQuickestStep);
}

// Nothing keeps it from its place, but its leg does not reach the ground from there: left so, it would be dragged along.
bool Footwork::hangs(const Foot& foot, const Place& place) {
  return !foot.stands && foot.rested > tune::kHangsFor && norm(foot.missed) < tune::kStopped &&
         norm(place.offset - place.home) > tune::kHangsAt * most(place);
}

bool Footwork::others_stand(const std::vector<Foot>& feet, size_t foot) {
  for (size_t f = 0; f < feet.size(); f++)
    if (f != foot && !feet[f].stands) return false;
  return feet.size() > 1;
}

// The foot in the air goes on. Seen from the body, its place comes towards it as fast as the body goes.
void Footwork::step(double dt) {
  Place& p = places_[steps_];
  const double before = least_jerk(time_ / lasts_);
  time_ = std::min(time_ + dt, lasts_);
  const double now = least_jerk(time_ / lasts_), left = lasts_ - time_;
  const double share = before < 1 ? (now - before) / (1 - before) : 1;
  if (time_ <= tune::kAims * lasts_ || before == 0)
    to_ = p.offset + share_ * (wanted(p) + left * speed_ - p.offset);
  p.offset += share * (to_ - p.offset);
  p.turn += share * ((1 - share_) * p.turn + left * spin_ - p.turn);
  // Of what is left that is less, so that it ends where there is ground.
  if (share < 1) share_ *= (1 - share) / (1 - share * share_);
  const double s = time_ / lasts_;
  p.raised = time_ < lasts_ ? 16 * tune::kStepHeight * s * s * (1 - s) * (1 - s) : 0;
  if (time_ >= lasts_) landed_ = steps_, steps_ = -1;
}

// A foot stays where it is, if a leg can reach it there.
void Footwork::stay(Place& place, Vec3 missed) {
  const Vec3 there = place.offset + missed;
  if (norm(there - place.home) > most(place)) return;
  place.offset = there;
  place.stopped = true;
}

void Footwork::limit(Place& place) {
  place.offset = place.home + capped(place.offset - place.home, most(place));
  place.turn = std::clamp(place.turn, -tune::kMostTurned, tune::kMostTurned);
}

void Footwork::frame(const std::vector<Foot>& feet, bool free, double dt, const Lands& lands) {
  Vec3 slid;
  double turned = 0;
  for (const Foot& foot : feet) {
    slid += (1.0 / feet.size()) * foot.slid;
    turned += foot.turned / feet.size();
  }
  const double share = 1 - elementary::exp(-dt / tune::kSlideTime);
  speed_ += share * ((1 / dt) * slid - speed_);
  spin_ += share * (turned / dt - spin_);
  if (norm2(slid) == 0 && norm(speed_) < tune::kNoSlide) speed_ = {};
  if (turned == 0 && std::fabs(spin_) < tune::kNoSlide) spin_ = 0;
  bool walks = false;  // a foot carries
  for (const Foot& foot : feet) walks |= free && foot.grounded && foot.rests > tune::kAtRestShare;
  const int landed = landed_;
  landed_ = -1;
  if (steps_ >= 0) step(others_stand(feet, (size_t)steps_) ? dt : tune::kInTheAirToo * dt);
  for (size_t f = 0; f < feet.size(); f++) {
    Place& p = places_[f];
    const bool held = p.held;
    p.held = feet[f].held;
    p.rests = feet[f].rests > tune::kAtRestShare && feet[f].grounded;
    p.stopped = false;
    if (p.held && !held) {
      stay(p, feet[f].missed);
      p.home = p.offset;
    }
    if (!p.held) p.home = {};
    // Who waits has a foot where its step has ended, as far as the leg reached: there it belongs.
    if (p.held && landed == (int)f) p.home = p.offset;
    if (steps((int)f)) to_ -= feet[f].slid;
    if (p.rests || steps((int)f)) {
      p.offset -= feet[f].slid;
      p.turn -= feet[f].turned;
      // What cannot get where it is to be stays where it is.
      if (p.held && !p.stopped && !steps((int)f) && norm(feet[f].missed) > tune::kStopped)
        stay(p, feet[f].missed);
    } else {
      const Vec3 way = (walks ? wanted(p) : p.home) - p.offset;
      const double most = tune::kGiveUp * dt, turn = tune::kGiveUpTurn * dt;
      p.offset += capped(way, most);
      p.turn -= std::clamp(p.turn, -turn, turn);
    }
    limit(p);
  }
  if (free && steps_ < 0) begin_step(feet, lands);
}

double Footwork::pace(Vec3 way) const {
  double pace = 1;
  for (const Place& p : places_) {
    const Vec3 behind = p.offset - p.home;
    if (!p.rests || dot(behind, way) >= 0) continue;
    const double left = (tune::kMostBehind - norm(behind)) / tune::kSlowsDown;
    pace = std::min(pace, std::max(left, tune::kSlowestPace));
  }
  return pace;
}

void Footwork::save(std::vector<double>& out) const {
  for (const Place& p : places_)
    out.insert(out.end(), {p.offset.x, p.offset.y, p.home.x, p.home.y, p.turn, p.raised,
                           (p.rests ? 1.0 : 0.0) + (p.held ? 2.0 : 0.0)});
  out.insert(out.end(), {speed_.x, speed_.y, spin_, (double)steps_, time_, lasts_, share_, to_.x,
                         to_.y, (double)landed_});
}

const double* Footwork::load(const double* in, size_t feet) {
  clear(feet);
  for (Place& p : places_) {
    p.offset = {in[0], in[1], 0};
    p.home = {in[2], in[3], 0};
    p.turn = in[4], p.raised = in[5], p.rests = (int)in[6] & 1, p.held = ((int)in[6] & 2) != 0;
    in += 7;
  }
  speed_ = {in[0], in[1], 0};
  spin_ = in[2], steps_ = (int)in[3], time_ = in[4], lasts_ = in[5], share_ = in[6];
  to_ = {in[7], in[8], 0};
  landed_ = (int)in[9];
  return in + 10;
}

}  // namespace hp
