// What people hold: bodies of their tree that no joint moves.
//
// A person has neither weight nor inertia while doing what the motion says; what they hold has both. The
// generalised force that a held thing asks for, by being where the motion takes it, is that of inverse
// dynamics with the thing as the only mass:
//
//   load = M_held dv_ref/dt + (Coriolis, centrifugal, gravity)_held
//
// The drive bears it as far as its strength goes (strength.cpp), so that who has strength enough follows
// the motion as if nothing were held. In everything else a held thing is a piece of its part.
#include "stepper.h"

namespace hp {

void Stepper::find_carried() {
  carried_.assign(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++)
    if (is_person(b) && model.dof_count[b] == 0) carried_[b] = carried_[model.root[b]] = 1;
}

void Stepper::find_load() {
  std::vector<char> massive;
  std::vector<double> velocity, acceleration;
  std::vector<int> bodies;
  for (const Drive& d : drives_) {
    const int root = d.body(0);
    if (!carries(d) || !world.active[root]) continue;
    massive = carried_;
    massive[root] = 0;
    velocity.resize(model.nv), acceleration.resize(model.nv);
    d.reference(velocity.data());
    d.reference_change(acceleration.data());
    bodies.clear();
    for (int b = root; b < model.nbody && model.root[b] == root; b++) bodies.push_back(b);
    bias_forces(model, start_.kin, velocity.data(), gravity, bodies, load_.data(),
                acceleration.data(), &massive);
  }
}

}  // namespace hp
