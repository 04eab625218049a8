// Where the friction of contact points acts: as far from the centre of their patch as its pressure lies.
//
// The points of one pair with one normal n are a patch: corners that hold an area. Pairs of one body that share
// a point make one patch: pieces that meet. Friction at the corners themselves would resist a turn about the
// normal by mu N times their distance from the centre, 1.5 times what a disc does, 1.85 times for a square.
// The friction of a point x therefore acts at
//
//     c + s (x - c)   in the plane across n through x,
//
// s the spread of the patch (geometry/patch_spread.h) and c its centre of pressure: the impulses of the
// substep before, weighted, or those of the last solve; of what has not touched before, the points by how
// much they are missing. The normal impulse stays at x. Friction has the same lever along the normal, so
// that tipping, rolling and sliding are as with s = 1; where all points slide one way their friction acts at
// c, as Coulomb's law over any distribution of the same pressure does. Both bodies have it at one place:
// momentum and angular momentum are kept exactly.
//
// The friction of people acts at the points themselves: drawn in, a foot that lands on a mattress turned its person
// 15 cm off the path, a suitcase slipped 5 cm in two palms, and arms that came out of the trunk were wedged.
//
// The spread is that of the true face where two rigid shapes meet, found anew when the patch gets a point that it
// had not in the substep before, until three of its points have carried something.
#pragma once
#include <vector>

#include "collision/collision_world.h"

namespace hp {

class FrictionPlaces {
 public:
  // Sets Contact::inward of patches with points that have none yet. The first `solved` contacts carry the
  // impulses of a solve; `missing(contact)` is by how much it would miss its target [m]; patches that turn far
  // within the substep, `turns(contact)`, are left as they are.
  template <typename Missing, typename Turns>
  void place(const CollisionWorld& world, Poses& start, const std::vector<CachedContact>& cached,
             const std::vector<ContactCandidate>& candidates, size_t solved,
             std::vector<Contact>& contacts, const Missing& missing, const Turns& turns) {
    for (size_t i = 0; i < contacts.size(); i++) {
      if (contacts[i].placed || !may_spread(world, contacts[i]) || turns(contacts[i])) continue;
      if (!find_patch(world, contacts, i)) continue;
      if (!find_centre_of_solved(contacts, solved) &&
          !find_centre_of_cached(world, start, cached, contacts)) {
        load_.clear();
        for (const size_t k : patch_) load_.push_back(missing(contacts[k]));
        find_centre_of_loads(contacts);
      }
      draw_in(contacts, find_spread(world, start, candidates, contacts));
    }
  }

 private:
  static bool may_spread(const CollisionWorld& world, const Contact& c);
  bool find_patch(const CollisionWorld& world, std::vector<Contact>& contacts, size_t first);
  bool find_centre_of_solved(const std::vector<Contact>& contacts, size_t solved);
  bool find_centre_of_cached(const CollisionWorld& world, Poses& start,
                             const std::vector<CachedContact>& cached,
                             const std::vector<Contact>& contacts);
  void find_centre_of_loads(const std::vector<Contact>& contacts);
  double find_spread(const CollisionWorld& world, Poses& start,
                     const std::vector<ContactCandidate>& candidates,
                     const std::vector<Contact>& contacts);
  void draw_in(std::vector<Contact>& contacts, double spread) const;

  std::vector<size_t> patch_;  // contacts of one patch
  std::vector<int> pairs_;     // of it
  std::vector<int64_t> keys_;  // of these
  std::vector<char> in_;       // per contact: it is in the patch
  std::vector<double> load_;   // of those of the patch
  Vec3 centre_;
};

}  // namespace hp
