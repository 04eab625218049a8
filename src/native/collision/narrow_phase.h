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
  PosedShape placed;
  std::shared_ptr<const TriangleTree> tree;
};

struct Pairing {  // of two names
  double friction = 0, restitution = 0;
  bool ignore = false;
};

// Two that are near enough to be looked at, and what is known of their distance. It only saves
// work: what is skipped for it could not have been a candidate.
struct BroadPhasePair {
  int shape = 0;
  int other_static = -1, other_shape = -1;  // one of them
  double dist = -1e300;       // lower bound when last looked at [m]
  double way = 0;             // what the two had travelled by then [m]
  std::vector<Plane> planes;  // all that the other has lies behind them, within `reach` of there
  double reach = 0;
  Vec3 axis;  // of the two nearest points when last looked at; 0: not yet
  Hint hint;  // of the two when last looked at
  bool own = false;  // two of one person: `way` counts what they travel within the root's frame
};

// A pair of shapes that may meet in this substep.
struct ContactCandidate {
  int shape = 0;
  int other_static = -1, other_shape = -1;  // one of them
  Vec3 n;             // from the other to the shape
  double offset = 0;  // static: the other lies in n.x <= offset
  double dist = 0;    // at the start of the substep
  double target = 0;  // distance demanded at its end
  double hard = 0;    // distance under which the step is shortened
  int triangle = -1;
  Hint hint;  // of two shapes at the start
  bool forgiven = false;  // the plane may be crossed: the thing behind it is not there
  bool searched = false;  // what its plane had hidden has been asked for
  // A shape that started inside is not where it is held to be: displaced by `from` at the start of
  // the substep and, where it makes `share` of that, by so much of the way to `to` at its end.
  int inside = -1;  // index of the pair
  Vec3 from, to;
  double share = 1;
  Vec3 shift() const { return from + share * (to - from); }
};

// A shape that started inside a static or, a part of a person, inside a thing. Displaced by `exit` it is
// clear of it, and on the right side; what is kept clear is the shape displaced by a part (1 - out) of
// that, and `out` only grows. docs/design.md, "Starting inside".
struct Inside {
  int shape = 0, other_static = -1, other_shape = -1;  // one of the two
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
struct CachedContact {
  int64_t key;
  int feature;
  Material point, other;  // on the shape; on the other shape: the point opposite
  Vec3 normal, impulse;   // in the world
  bool used;
};

// How shapes get from one pose to another, without contact [m].
struct Sweep {
  std::vector<double> way;    // no point of the shape goes farther
  std::vector<double> straight;  // the part of `way` that its end pose alone tells
  std::vector<double> bulge;  // nor strays farther from the straight line between its ends
  std::vector<double> inner;  // `straight` as seen from the root; empty without self-contact
};

class World {
 public:
  std::vector<CollisionShape> shapes;
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
  // The shapes of active trees have gone from one pose to another, no farther than `way`; seen from
  // their roots no farther than `inner`, which is empty without self-contact.
  void travel(const std::vector<double>& way, const std::vector<double>& inner);
  // Lists all pairs that can come within `way[shape]` of each other, and some that cannot, unless
  // the list that there is says so already.
  void list(const Model& m, const Poses& p, const std::vector<double>& way);
  // Marks (per body) the trees of pairs that a sweep does not prove to stay clear of each other.
  void find_busy(const Model& m, Poses& start, Poses& end, const Sweep& sweep,
                 std::vector<char>& busy);
  double travelled(int shape) const { return odometer_[shape]; }

  // Self-contact (self_contact.cpp): the pairs of shapes of one tree that may touch each other.
  void set_self_pairs(const std::vector<std::pair<int, int>>& pairs);
  // Who is inside of themselves still chooses anew where to leave, now and then.
  void choose_again(const Model& m, Poses& start);
  // Distance of two shapes; where they overlap, minus the least depth found.
  double gap(Poses& p, int a, int b) const;
  bool self_contact() const { return !self_.empty(); }
  // How far no point of each shape goes between two poses, seen from the root; empty without
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
  const PosedShape& place(Poses& p, int shape) const;

  // Remembers the pairs that start nearer than the clearance, or inside each other.
  void reset(const Model& m, Poses& start);
  // All listed pairs within `reach[shape]` of each other.
  void gather(const Model& m, Poses& start, const std::vector<double>& reach, double h,
              std::vector<ContactCandidate>& out);
  // Smallest gap of a candidate at the end pose minus what it demands; forgives planes that are
  // crossed where nothing is behind them.
  double excess(Poses& start, Poses& end, ContactCandidate& c) const;
  // Is the whole mesh of a candidate out of the way from start to end?
  bool mesh_clear(const ContactCandidate& c, Poses& start, Poses& end) const;
  // A plane of a mesh that may be crossed hides nothing: appends the candidates behind it.
  void search_behind(Poses& start, const std::vector<double>& reach, double h, int index,
                     std::vector<ContactCandidate>& all);
  // Adds contact points of a violated candidate, or better ones than in the passes before.
  void add_contacts(const std::vector<CachedContact>& remembered, Poses& start, Poses& end,
                    const ContactCandidate& c, int index, int pass,
                    std::vector<Contact>& contacts) const;
  // Whether a person meets something that moves.
  bool handles(const ContactCandidate& c) const {
    return c.other_shape >= 0 &&
           (shapes[c.shape].person >= 0 || shapes[c.other_shape].person >= 0);
  }
  // Marks those pairs of them that had contacts in the substep before; true if there are any.
  bool recall(const std::vector<CachedContact>& remembered, const std::vector<ContactCandidate>& candidates,
              std::vector<char>& out) const;
  // The gap that a contact's own points have at the end pose.
  double gap_at(Poses& start, Poses& end, const Contact& c) const;
  // Smallest distance of a person's parts from the statics, up to `range`, inf beyond.
  double clearance(const Model& m, Poses& p, double range) const;
  // The same of every shape, and the static that it is from (-1: none within `range`); NaN for
  // objects. Looks at all pairs: slower, but nothing has to be known of them.
  void clearances(Poses& p, double range, double* dist, int* nearest) const;

  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // Of pairs that were there before, what was known then: `shape` says whose number each has in `old`
  // (-1: new).
  void adopt(const World& old, const std::vector<int>& shape);

 private:
  struct PairState {
    double clearance = 0;  // its own: it started nearer
    bool inside = false;   // of two shapes
    Vec3 exit;             // direction out, where inside
    bool through = false;  // two people who start in one place pass through until they are out
    bool kept = false;  // pieces that overlap where their surfaces are clear get no deeper
  };
  static int64_t key(const ContactCandidate& c) {
    return ((int64_t)c.shape << 32) | (int64_t)(c.other_static >= 0 ? 2 * c.other_static
                                                                    : 2 * c.other_shape + 1);
  }
  static ContactCandidate unpacked(int64_t key) {
    ContactCandidate c;
    c.shape = (int)(key >> 32);
    const int other = (int)(key & 0xffffffff);
    (other % 2 == 0 ? c.other_static : c.other_shape) = other / 2;
    return c;
  }
  template <typename Make>
  void add_rim_contacts(const PosedShape& a0, const PosedShape& a1, const ContactCandidate& c, int index,
                        Make make, std::vector<Contact>& contacts) const;
  bool may_touch(const Model& m, int a, int b) const;
  double way_of(const BroadPhasePair& e) const {
    if (e.own) return inner_[e.shape] + inner_[e.other_shape];
    return odometer_[e.shape] + (e.other_shape >= 0 ? odometer_[e.other_shape] : 0.0);
  }
  bool far(const BroadPhasePair& e, double r) const { return e.dist - (way_of(e) - e.way) > r; }
  void save_near(std::vector<double>& out) const;
  const double* load_near(const double* in);
  bool behind_planes(const BroadPhasePair& e, const PosedShape& a, double r) const;
  void look(Poses& p, BroadPhasePair& e, double r);
  bool takes_part(const BroadPhasePair& e) const;
  // Of two shapes of one tree: do their bounding spheres keep them farther apart than r? May they
  // touch on their way? The direction along which they overlap least.
  bool spheres_apart(Poses& p, BroadPhasePair& e, double r) const;
  bool meets_itself(const Model& m, Poses& start, Poses& end, const Sweep& sweep, BroadPhasePair& e) const;
  void leave_together(const Model& m, Poses& start);
  int waited_ = 0;  // substeps since those who leave themselves were last looked at
  double depth_ = 1e300;  // how deep they all were then, along their ways out [m]
  bool may_touch_itself(int a, int b) const {
    return !self_.empty() && self_[a * shapes.size() + b];
  }
  // Of two bodies of one person the one that carries more: the way out turns with it.
  int stays(const Model& m, const ContactCandidate& c) const {
    const int a = shapes[c.shape].body, b = shapes[c.other_shape].body;
    return m.carried[a] > m.carried[b] ? a : b;
  }
  static Vec3 least_overlap(const PosedShape& a, const PosedShape& b, Vec3 guess);
  void demand(ContactCandidate& c, double h);
  double pace_of(const ContactCandidate& c) const {
    if (!forced || !handles(c)) return 1;
    const int thing = shapes[c.other_shape].body;
    return squeezed[thing] ? 0 : pace[thing];
  }
  // Of things that people were put into (forced.cpp).
  void find_exits(const Model& m, Poses& start);
  bool exits_known_ = true;
  // Of a pair, the plane that it is to stay behind, among the candidates.
  void take(ContactCandidate& c, const Plane& p, double h, std::vector<ContactCandidate>& out);
  // Starting inside (inside.cpp).
  struct Overlap {
    int shape, other_static, other_shape;
  };
  struct Obstacle;
  void find_inside(const Model& m, Poses& start, const std::vector<Overlap>& overlaps);
  void way_out(const Model& m, Poses& start, const Obstacle& o, const std::vector<int>& group,
               const std::vector<char>& moves, const std::vector<char>& stays);
  void gather_inside(Poses& start, BroadPhasePair& e, Inside& in, double reach, double h,
                     std::vector<ContactCandidate>& out);
  Inside* inside_of(const BroadPhasePair& e);
  bool is_inside(int shape, int other_static, int other_shape) const;
  bool clear_of(Poses& start, int shape, const Obstacle& o, Vec3 shift, double range) const;
  double bulge(int shape, const Poses& start, const Poses& end, const Mat3& back) const;
  bool swept_clear(const PosedShape& a0, const PosedShape& a1, const ContactCandidate& c, Poses& start,
                   Poses& end) const;

  std::map<int64_t, PairState> pairs_;
  std::vector<Inside> inside_;
  Vec3 avoid_;  // a way out that is not to be tried again; 0: none
  std::vector<BroadPhasePair> broad_pairs_;
  std::vector<double> odometer_, listed_, range_;  // per shape [m]
  std::vector<char> self_;     // shapes x shapes: of one tree, and may touch; empty: none
  std::vector<double> inner_;  // per shape: what it travelled within its root's frame [m]
  bool has_list_ = false;
  // Of mesh_clear(), for the end pose that has this stamp.
  struct Way {
    int shape, other_static;
    bool clear;
  };
  mutable std::vector<Way> ways_;
  mutable unsigned ways_of_ = 0, stamps_ = 0;
};

}  // namespace hp
