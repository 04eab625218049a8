// Joints that nothing touches follow the motion.
//
// Contacts stop the part that they touch, and through M^^-1 whatever hangs on it: a body that runs
// into a wall threw its jaw and its feet about, and went on doing so while it pressed on. In M^ = s
// (M + X) the firmness gives a joint lambda times its own inertia; a joint beyond which nothing
// touches gets kUntouchedResistance times that. Bodies that contacts push give way as before, and
// so do all joints between them and the root. With lambda = 0 nothing is held, nor with Algorithm 1
// of the paper, nor a person whose strength is exceeded (strength.h).
//
// A person in contact with an object or with themselves is not held at all: fingers close about an
// object with all that they touch, one after the other, and a ball between two palms was lost where
// the fingers that did not touch yet were held.
//
// A body is touched if a contact on it carries an impulse. Bodies that were touched lately are
// taken for touched at first; if solving finds more, those are released and all is solved again.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

// Calls each(b) for the bodies of people that a contact of this pair pushes.
template <typename Each>
void for_each_pushed(const System& system, const ContactCandidate& c, Each each) {
  const Model& model = system.model;
  const std::vector<CollisionShape>& shapes = system.world.shapes;
  const int ends[2] = {shapes[c.shape].body, c.other_shape < 0 ? 0 : shapes[c.other_shape].body};
  for (int side = 0; side < 2; side++) {
    const int body = ends[side], other = ends[1 - side];
    if (!system.is_person(body)) continue;
    if (other > 0 && (!system.is_person(other) || model.root[other] == model.root[body])) {
      for (int b = 1; b < model.nbody; b++)
        if (model.root[b] == model.root[body]) each(b);
    }
    for (int b = body; b > 0; b = model.parent[b]) each(b);
  }
}

class UntouchedJoints {
 public:
  // An attempt begins: touched is what contacts pushed lately.
  void begin(const System& system, JointResistance& resistance, EffectiveInertia& inertia) const;
  // Marks what contacts push now. True if a joint of it was held until now: then all is to be
  // solved again, for the trees that released() marks (per root body).
  bool release(const System& system, const Attempt& attempt, JointResistance& resistance,
               EffectiveInertia& inertia);
  const std::vector<char>& released() const { return released_; }

 private:
  std::vector<char> released_;
};

}  // namespace hp
