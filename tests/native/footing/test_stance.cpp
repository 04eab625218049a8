// The reference as the body has it.
#include "footing/stance.h"

#include "check.h"
#include "small_person.h"

namespace {

using hp::Footwork;
using hp::Quat;
using hp::Stance;
using hp::Vec3;

constexpr double kDt = 1.0 / 60;

// The small person's one leg; its shank ends in the foot.
hp::FootingModel footing_model() {
  hp::Leg leg;
  leg.root = 1, leg.hip = 3, leg.knee = leg.ankle = leg.toes = 4;
  hp::SkinPoint sole;
  sole.body[0] = sole.body[1] = 4;
  sole.local[0] = sole.local[1] = {0, 0, -0.4};
  leg.sole.push_back(sole);
  hp::FootingModel model;
  model.legs.push_back(leg);
  return model;
}

hp::Model finished() {
  hp::Model m = small_person::model();
  m.finish();
  return m;
}

struct Story {
  const hp::Model m = finished();
  const hp::FootingModel model = footing_model();
  Footwork feet;
  Stance stance;
  Story() { feet.clear(1), stance.clear(1); }
  void read(Stance& s, int frame, Quat turned) {
    s.read(m, model, feet, {kDt, kDt, 9.81, turned, 0},
           small_person::pose(frame * kDt, 0.9).data());
  }
  // Where the ankle is in the motion itself.
  Vec3 ankle(int frame) {
    hp::Kinematics k;
    k.resize(m);
    k.update(m, small_person::pose(frame * kDt, 0.9).data());
    return k.xpos[4];
  }
};

// What a foot does in the motion, turned like the body, and what carries it aside besides are all that it is seen to do.
void who_is_turned_goes_aside_by_what_its_feet_do_not_do() {
  Story story;
  const Quat turned = hp::exp_quat({0, 0, 0.7});
  story.read(story.stance, 0, turned);
  CHECK(hp::norm(story.stance.goes_aside()) == 0);
  double most = 0;
  for (int frame = 1; frame < 30; frame++) {
    const Vec3 before = story.stance.kin.xpos[4];
    story.read(story.stance, frame, turned);
    Vec3 rest = story.stance.kin.xpos[4] - before -
                hp::to_matrix(turned) * (story.ankle(frame) - story.ankle(frame - 1));
    CHECK_NEAR(hp::norm(story.stance.goes_aside() - rest), 0, 1e-12);
    most = std::max(most, hp::norm(rest));
  }
  CHECK(most > 1e-3);  // [m]
}

void who_is_not_turned_goes_nowhere_aside() {
  Story story;
  for (int frame = 0; frame < 10; frame++) {
    story.read(story.stance, frame, {});
    CHECK(hp::norm(story.stance.goes_aside()) == 0);
  }
}

void saved_and_loaded_it_goes_on() {
  Story story;
  const Quat turned = hp::exp_quat({0.1, 0, -0.4});
  for (int frame = 0; frame < 5; frame++) story.read(story.stance, frame, turned);
  std::vector<double> saved;
  story.stance.save(saved);
  Stance loaded;
  CHECK(loaded.load(saved.data(), story.model) == saved.data() + saved.size());
  story.read(story.stance, 5, turned), story.read(loaded, 5, turned);
  const Vec3 a = story.stance.goes_aside(), b = loaded.goes_aside();
  CHECK(hp::norm(a) > 0);
  CHECK(a.x == b.x && a.y == b.y && a.z == b.z);
  CHECK(story.stance.speed[0] == loaded.speed[0]);
}

}  // namespace

int main() {
  who_is_turned_goes_aside_by_what_its_feet_do_not_do();
  who_is_not_turned_goes_nowhere_aside();
  saved_and_loaded_it_goes_on();
  return check::report("stance");
}
