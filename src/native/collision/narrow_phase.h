// Who could touch whom in the next substep, and what it takes to keep them apart.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "geometry/bvh.h"
#include "geometry/convex.h"
#include "collision/collision_shape.h"
#include "contact/solver.h"
#include "dynamics/kinematic_tree.h"

namespace hp {

struct Static {
  enum class Kind { HalfSpace, Hull, Mesh } kind = Kind::HalfSpace;
  int name = 0;
  Vec3 n;             // half-space n.x <= offset
  double offset = 0;
  Convex shape;       // hull, in the world frame
  Placed placed;
  std::shared_ptr<const TriangleTree> tree;
};

struct Pairing {  // of two names
  double friction = 0, restitution = 0;
  bool ignore = false;
};

// Two that are near enough to be looked at, and what is known of their distance. It only saves
// work: what is skipped for it could not have been a candidate.
struct Near {
  int mover = 0;
  int other_static = -1, other_mover = -1;  // one of them
  double dist = -1e300;       // lower bound when last looked at [m]
  double way = 0;             // what the two had travelled by then [m]
  std::vector<Plane> planes;  // all that the other has lies behind them, within `reach` of there
  double reach = 0;
  Vec3 axis;  // of the two nearest points when last looked at; 0: not yet
  Hint hint;  // of the two when last looked at
  bool own = false;  // two of one person: `way` counts what they travel within the root's frame
};

// A pair of shapes that may meet in this substep.
struct Candidate {
  int mover = 0;
  int other_static = -1, other_mover = -1;  // one of them
  Vec3 n;             // from the other to the mover
  double offset = 0;  // static: the other lies in n.x <= offset
  double dist = 0;    // at the start of the substep
  double target = 0;  // distance demanded at its end
  double hard = 0;    // distance under which the step is shortened
  int triangle = -1;
  Hint hint;  // of two movers at the start
  bool forgiven = false;  // the plane may be crossed: the thing behind it is not there
  bool searched = false;  // what its plane had hidden has been asked for
  // A mover that started inside is not where it is held to be: displaced by `from` at the start of
  // the substep and, where it makes `share` of that, by so much of the way to `to` at its end.
  int inside = -1;  // index of the pair
  Vec3 from, to;
  double share = 1;
  Vec3 shift() const { return from + share * (to - from); }
};

// A mover that started inside a static or, a part of a person, inside a thing. Displaced by `exit` it is
// clear of it, and on the right side; what is kept clear is the mover displaced by a part (1 - out) of
// that, and `out` only grows. docs/design.md, "Starting inside".
struct Inside {
  int mover = 0, other_static = -1, other_mover = -1;  // one of the two
  Vec3 exit;
  double out = 0;   // 1: it has come out
  double next = 0;  // what it will be at the end of the substep
  bool lost = false;  // no way out was found: nothing holds it until it is clear
  double pace = 0;    // how far it should come in the substep [m]
  int stuck = 0;      // substeps in a row in which it hardly got on
  double depth() const { return (1 - out) * norm(exit); }
};

// Where all demands cannot be met, clearances give way down to this [m].
constexpr double kLeastGap = 1e-4;

struct ContactSettings {
  double clearance = 1e-3, depenetration_speed = 0.5, tolerance = 1e-6;
  int max_sweeps = 50;
};

// A contact point that carried something in the substep before.
struct Remembered {
  int64_t key;
  int feature;
  Material point, other;  // on the mover; on the other mover: the point opposite
  Vec3 normal, impulse;   // in the world
  bool used;
};

// How movers get from one pose to another, without contact [m].
struct Sweep {
  std::vector<double> way;    // no point of the mover goes farther
  std::vector<double> straight;  // the part of `way` that its end pose alone tells
  std::vector<double> bulge;  // nor strays farther from the straight line between its ends
  std::vector<double> inner;  // `straight` as seen from the root; empty without self-contact
};

class World {
 public:
  std::vector<Mover> movers;
  std::vector<Static> statics;
  std::vector<Pairing> pairings;  // names x names
  int n_names = 0;
  ContactSettings settings;

  const Pairing& pairing(int a, int b) const { return pairings[a * n_names + b]; }
  // Trees that take part, per body; the others' pairs are left out.
  std::vector<char> active;
  // Trees that have made their step already (per body), and stand in the way of those that take
  // part.
  std::vector<char> standing;
  // Trees (per body) that hang where they are until something touches them: nothing else is in their way.
  std::vector<char> asleep;
  // People's poses are set: nothing that stands is in their way, and what they are inside of is found anew.
  bool forced = false;
  // They have been put somewhere else: ways out of them are forgotten, to be found by the next gather().
  void people_put();
  // Per body: how fast a thing leaves them in the next substep, as a share of what is asked.
  std::vector<double> pace;
  // Per body: things between two of them that would have to leave both ways at once.
  std::vector<char> squeezed;

  // Everybody is somewhere else now: nothing is known of distances.
  void forget();
  // The movers of active trees have gone from one pose to another, no farther than `way`; seen from
  // their roots no farther than `inner`, which is empty without self-contact.
  void travel(const std::vector<double>& way, const std::vector<double>& inner);
  // Lists all pairs that can come within `way[mover]` of each other, and some that cannot, unless
  // the list that there is says so already.
  void list(const Model& m, const Poses& p, const std::vector<double>& way);
  // Marks (per body) the trees of pairs that a sweep does not prove to stay clear of each other.
  void find_busy(const Model& m, Poses& start, Poses& end, const Sweep& sweep,
                 std::vector<char>& busy);
  double travelled(int mover) const { return odometer_[mover]; }

  // Self-contact (self_contact.cpp): the pairs of movers of one tree that may touch each other.
  void set_self_pairs(const std::vector<std::pair<int, int>>& pairs);
  // Who is inside of themselves still chooses anew where to leave, now and then.
  void choose_again(const Model& m, Poses& start);
  // Distance of two movers; where they overlap, minus the least depth found.
  double gap(Poses& p, int a, int b) const;
  bool self_contact() const { return !self_.empty(); }
  // How far no point of each mover goes between two poses, seen from the root; empty without
  // self-contact.
  void inner_ways(const Model& m, const Poses& from, const Poses& to, std::vector<double>& way) const;

  // Who started inside something and is not out yet.
  const std::vector<Inside>& inside() const { return inside_; }
  bool any_inside() const { return !inside_.empty(); }
  // How fast they come out in the next substep, as a share of what is asked.
  double growth = 1;
  // Who is stuck on the way out tries another one.
  void reroute(const Model& m, Poses& start);
  // The substep has been made, by the trees' shares of it (per body; empty: whole).
  void come_out(const std::vector<double>& share);

  void start_poses(Poses& p) const;
  const Placed& place(Poses& p, int mover) const;

  // Remembers the pairs that start nearer than the clearance, or inside each other.
  void reset(const Model& m, Poses& start);
  // All listed pairs within `reach[mover]` of each other.
  void gather(const Model& m, Poses& start, const std::vector<double>& reach, double h,
              std::vector<Candidate>& out);
  // Smallest gap of a candidate at the end pose minus what it demands; forgives planes that are
  // crossed where nothing is behind them.
  double excess(Poses& start, Poses& end, Candidate& c) const;
  // Is the whole mesh of a candidate out of the way from start to end?
  bool mesh_clear(const Candidate& c, Poses& start, Poses& end) const;
  // A plane of a mesh that may be crossed hides nothing: appends the candidates behind it.
  void search_behind(Poses& start, const std::vector<double>& reach, double h, int index,
                     std::vector<Candidate>& all);
  // Adds contact points of a violated candidate, or better ones than in the passes before.
  void add_contacts(const std::vector<Remembered>& remembered, Poses& start, Poses& end,
                    const Candidate& c, int index, int pass,
                    std::vector<Contact>& contacts) const;
  // Whether a person meets something that moves.
  bool handles(const Candidate& c) const {
    return c.other_mover >= 0 &&
           (movers[c.mover].person >= 0 || movers[c.other_mover].person >= 0);
  }
  // Marks those pairs of them that had contacts in the substep before; true if there are any.
  bool recall(const std::vector<Remembered>& remembered, const std::vector<Candidate>& candidates,
              std::vector<char>& out) const;
  // The gap that a contact's own points have at the end pose.
  double gap_at(Poses& start, Poses& end, const Contact& c) const;
  // Smallest distance of a person's parts from the statics, up to `range`, inf beyond.
  double clearance(const Model& m, Poses& p, double range) const;
  // The same of every mover, and the static that it is from (-1: none within `range`); NaN for
  // objects. Looks at all pairs: slower, but nothing has to be known of them.
  void clearances(Poses& p, double range, double* dist, int* nearest) const;

  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // Of pairs that were there before, what was known then: `mover` says whose number each has in `old`
  // (-1: new).
  void adopt(const World& old, const std::vector<int>& mover);

 private:
  struct PairState {
    double clearance = 0;  // its own: it started nearer
    bool inside = false;   // of two movers
    Vec3 exit;             // direction out, where inside
    bool through = false;  // two people who start in one place pass through until they are out
    bool kept = false;  // pieces that overlap where their surfaces are clear get no deeper
  };
  static int64_t key(const Candidate& c) {
    return ((int64_t)c.mover << 32) | (int64_t)(c.other_static >= 0 ? 2 * c.other_static
                                                                    : 2 * c.other_mover + 1);
  }
  static Candidate unpacked(int64_t key) {
    Candidate c;
    c.mover = (int)(key >> 32);
    const int other = (int)(key & 0xffffffff);
    (other % 2 == 0 ? c.other_static : c.other_mover) = other / 2;
    return c;
  }
  template <typename Make>
  void add_rim_contacts(const Placed& a0, const Placed& a1, const Candidate& c, int index,
                        Make make, std::vector<Contact>& contacts) const;
  bool may_touch(const Model& m, int a, int b) const;
  double way_of(const Near& e) const {
    if (e.own) return inner_[e.mover] + inner_[e.other_mover];
    return odometer_[e.mover] + (e.other_mover >= 0 ? odometer_[e.other_mover] : 0.0);
  }
  bool far(const Near& e, double r) const { return e.dist - (way_of(e) - e.way) > r; }
  void save_near(std::vector<double>& out) const;
  const double* load_near(const double* in);
  bool behind_planes(const Near& e, const Placed& a, double r) const;
  void look(Poses& p, Near& e, double r);
  bool takes_part(const Near& e) const;
  // Of two movers of one tree: do their bounding spheres keep them farther apart than r? May they
  // touch on their way? The direction along which they overlap least.
  bool spheres_apart(Poses& p, Near& e, double r) const;
  bool meets_itself(const Model& m, Poses& start, Poses& end, const Sweep& sweep, Near& e) const;
  void leave_together(const Model& m, Poses& start);
  int waited_ = 0;  // substeps since those who leave themselves were last looked at
  double depth_ = 1e300;  // how deep they all were then, along their ways out [m]
  bool may_touch_itself(int a, int b) const {
    return !self_.empty() && self_[a * movers.size() + b];
  }
  // Of two bodies of one person the one that carries more: the way out turns with it.
  int stays(const Model& m, const Candidate& c) const {
    const int a = movers[c.mover].body, b = movers[c.other_mover].body;
    return m.carried[a] > m.carried[b] ? a : b;
  }
  static Vec3 least_overlap(const Placed& a, const Placed& b, Vec3 guess);
  void demand(Candidate& c, double h);
  double pace_of(const Candidate& c) const {
    if (!forced || !handles(c)) return 1;
    const int thing = movers[c.other_mover].body;
    return squeezed[thing] ? 0 : pace[thing];
  }
  // Of things that people were put into (forced.cpp).
  void find_exits(const Model& m, Poses& start);
  bool exits_known_ = true;
  // Of a pair, the plane that it is to stay behind, among the candidates.
  void take(Candidate& c, const Plane& p, double h, std::vector<Candidate>& out);
  // Starting inside (inside.cpp).
  struct Overlap {
    int mover, other_static, other_mover;
  };
  struct Obstacle;
  void find_inside(const Model& m, Poses& start, const std::vector<Overlap>& overlaps);
  void way_out(const Model& m, Poses& start, const Obstacle& o, const std::vector<int>& group,
               const std::vector<char>& moves, const std::vector<char>& stays);
  void gather_inside(Poses& start, Near& e, Inside& in, double reach, double h,
                     std::vector<Candidate>& out);
  Inside* inside_of(const Near& e);
  bool is_inside(int mover, int other_static, int other_mover) const;
  bool clear_of(Poses& start, int mover, const Obstacle& o, Vec3 shift, double range) const;
  double bulge(int mover, const Poses& start, const Poses& end, const Mat3& back) const;
  bool swept_clear(const Placed& a0, const Placed& a1, const Candidate& c, Poses& start,
                   Poses& end) const;

  std::map<int64_t, PairState> pairs_;
  std::vector<Inside> inside_;
  Vec3 avoid_;  // a way out that is not to be tried again; 0: none
  std::vector<Near> near_;
  std::vector<double> odometer_, listed_, range_;  // per mover [m]
  std::vector<char> self_;     // movers x movers: of one tree, and may touch; empty: none
  std::vector<double> inner_;  // per mover: what it travelled within its root's frame [m]
  bool has_list_ = false;
  // Of mesh_clear(), for the end pose that has this stamp.
  struct Way {
    int mover, other_static;
    bool clear;
  };
  mutable std::vector<Way> ways_;
  mutable unsigned ways_of_ = 0, stamps_ = 0;
};

}  // namespace hp
