// Distances to hard frames, and pressures as a few points with the same force, moments and stiffness.
#include "check.h"
#include "soft/condensation.h"

namespace {

using hp::Vec3;

using N = hp::NearSamples;

// One more sample with an area of 4 cm^2 on a layer of 10 cm that faces along n, at x.
void add(hp::SoftPair& pair, Vec3 x, Vec3 n, double before, double depth) {
  N& near = pair.near;
  const int i = near.add(near.size());
  near.set_law(i, {2e5, 0, 0, 0, 1});
  near.set(N::Hard, i, x), near.set(N::First, i, x), near.set(N::Away, i, n);
  near[N::Area][i] = 4e-4, near[N::Edge][i] = 1e-5, near[N::Thickness][i] = 0.1;
  near[N::Before][i] = before, near[N::Depth][i] = depth;
}

// A field of 2 cm pressed into a plane layer with a tilt and a curvature.
hp::SoftPair field(double tilt, double bend, Vec3 n = {0, 0, 1}) {
  hp::SoftPair pair;
  for (int i = 0; i < 12; i++)
    for (int j = 0; j < 7; j++) {
      const Vec3 x{0.02 * i + 0.3, 0.02 * j - 0.1, 0.5};
      const double u = x.x - 0.41, v = x.y + 0.04;
      add(pair, x, n, 0.02, 0.02 + tilt * u - 0.5 * tilt * v - bend * u * u);
    }
  return pair;
}

struct Sums {
  double force = 0, along_x = 0, along_y = 0, xx = 0, xy = 0, yy = 0, yield = 0;
  void add(Vec3 x, double q, double s) {
    force += q, along_x += q * x.x, along_y += q * x.y;
    yield += s, xx += s * x.x * x.x, xy += s * x.x * x.y, yy += s * x.y * x.y;
  }
};

// Force, both moments, and their derivatives by sinking and tilting, in both rules.
void points_have_the_force_moments_and_stiffness_of_the_samples() {
  const double h = 1.0 / 240;
  for (const hp::Rule rule : {hp::Rule::End, hp::Rule::Mean}) {
    hp::SoftPair pair = field(0.06, 0);
    hp::find_pressures(rule, h, pair);
    Sums exact, found;
    const double share = hp::moving_share(rule);
    for (int i = 0; i < pair.near.size(); i++) {
      const double area = share * h * pair.near[N::Area][i];
      exact.add(pair.near.vector(N::Hard, i), area * pair.near[N::Pressure][i],
                h * area * pair.near[N::Slope][i]);
    }
    hp::PressedSamples pressed;
    hp::list_pressed(pair, 0, rule, h, {}, pressed);
    std::vector<hp::PatchPoint> points;
    hp::condense(pressed, 0, points);
    CHECK(points.size() == 4);
    for (const hp::PatchPoint& p : points) {
      CHECK(p.impulse > 0 && p.n.z > 1 - 1e-12);
      found.add(p.x, p.impulse, p.yield);
    }
    for (double Sums::* sum : {&Sums::force, &Sums::along_x, &Sums::along_y, &Sums::yield,
                               &Sums::xx, &Sums::xy, &Sums::yy})
      CHECK_NEAR(found.*sum, exact.*sum, 1e-10 * std::fabs(exact.*sum));
  }
}

// Where a point would have to pull, the force and both moments are right still.
void no_point_pulls() {
  hp::SoftPair pair = field(0.16, 8);
  hp::find_pressures(hp::Rule::End, 1.0 / 240, pair);
  hp::PressedSamples pressed;
  hp::list_pressed(pair, 0, hp::Rule::End, 1.0 / 240, {}, pressed);
  std::vector<hp::PatchPoint> points;
  hp::condense(pressed, 0, points);
  const hp::PairImpulse exact = hp::total_impulse({&pair}, hp::Rule::End, 1.0 / 240, {}, {});
  Vec3 force, moment;
  for (const hp::PatchPoint& p : points) {
    CHECK(p.impulse >= 0);
    force += p.impulse * p.n, moment += p.impulse * cross(p.x, p.n);
  }
  CHECK_NEAR(norm(force - exact.force), 0, 1e-12 * norm(exact.force));
  CHECK_NEAR(norm(moment - exact.moment), 0, 1e-10 * norm(exact.moment));
}

// A discrete gradient: the force over the way is what the springs store, at any step.
void the_mean_rule_stores_what_it_takes() {
  hp::SoftPair pair = field(0.06, 2);
  N& near = pair.near;
  for (int i = 0; i < near.size(); i++) near[N::Densification][i] = 5;
  hp::find_pressures(hp::Rule::Mean, 1.0 / 30, pair);
  for (int i = 0; i < near.size(); i++) {
    const double before = near[N::Before][i], depth = near[N::Depth][i];
    const double stored = near.law(i).energy(depth, 0.1) - near.law(i).energy(before, 0.1);
    CHECK_NEAR(near[N::Pressure][i] * (depth - before), stored, 1e-6 * std::fabs(stored) + 1e-9);
  }
}

// The lanes of the end rule are the law, sample by sample: springs, their spread, damping, and the Maxwell arm.
void the_end_rule_is_the_law() {
  const double h = 1.0 / 240;
  hp::SoftPair pair = field(0.3, 3);
  N& near = pair.near;
  for (int i = 0; i < near.size(); i++) {
    near.set_law(i, {2e5, 3e3, 1.5, 0.3, 0.5});
    near[N::Before][i] = 0.02 - 1e-3 * (i % 7);
    near[N::Edge][i] = 2e-3 + 1e-4 * (i % 5), near[N::Gone][i] = 1e-3 * (i % 3);
  }
  hp::find_pressures(hp::Rule::End, h, pair);
  int pressed = 0;
  for (int i = 0; i < near.size(); i++) {
    const double d = near[N::Depth][i], e = near[N::Edge][i], before = near[N::Before][i];
    const hp::SoftLaw law = near.law(i);
    const double share = std::fmin(1, std::fmax(0, (d + e) / (2 * e)));
    const double arm = 0.3 * 2e5 / (1 + h / 0.5);
    double p = (law.energy(d + e, 0.1) - law.energy(d - e, 0.1)) / (2 * e);
    double s = (law.pressure(d + e, 0.1) - law.pressure(d - e, 0.1)) / (2 * e);
    p += share * (3e3 * (d - before) / h + arm * (d - near[N::Gone][i]));
    s += share * (3e3 / h + arm);
    const bool pushes = p > 0 && std::fmax(d, before) > -e;
    pressed += pushes;
    CHECK_NEAR(near[N::Pressure][i], pushes ? p : 0, 1e-12 * std::fabs(p) + 1e-9);
    CHECK_NEAR(near[N::Slope][i], pushes ? s : 0, 1e-12 * s);
  }
  CHECK(pressed > 20 && pressed < near.size());
}

// Of two surfaces that face apart, as between a seat and its back, each has its own points.
void surfaces_that_face_apart_are_patches() {
  hp::SoftPair pair = field(0, 0);
  const hp::SoftPair back = field(0, 0, {1, 0, 0});
  for (int i = 0; i < back.near.size(); i++)
    add(pair, back.near.vector(N::Hard, i), {1, 0, 0}, 0.02, 0.02);
  hp::find_pressures(hp::Rule::End, 1.0 / 240, pair);
  hp::PressedSamples pressed;
  hp::list_pressed(pair, 0, hp::Rule::End, 1.0 / 240, {}, pressed);
  std::vector<hp::PatchPoint> points;
  hp::condense(pressed, 0, points);
  CHECK(points.size() == 6);  // the second is seen from its edge
  for (const hp::PatchPoint& p : points) CHECK(p.n.z > 1 - 1e-12 || p.n.x > 1 - 1e-12);
}

// A box, closed form and GJK; from its face, edge and corner.
void a_box_is_as_far_as_by_gjk() {
  hp::CollisionWorld world;
  hp::SoftWorld soft;
  hp::Static box;
  box.kind = hp::Static::Kind::Hull;
  for (int k = 0; k < 8; k++)
    box.hull.vertices.push_back({k & 1 ? 0.7 : -0.3, k & 2 ? 0.2 : -0.4, k & 4 ? 1.1 : 0.9});
  box.hull.radius = 0.02;
  box.hull.finish();
  box.posed.place(box.hull, {}, {});
  world.statics = {box, box};
  world.statics[0].hull.normals = {{0, 1, 0}, {0, 0, 1}};
  for (hp::Static& s : world.statics) s.posed.hull = &s.hull;
  soft.find_boxes(world);
  CHECK(soft.static_boxes[0].is && !soft.static_boxes[1].is);
  for (const Vec3 x : {Vec3{0.1, 0, 1.25}, Vec3{0.9, 0, 1.2}, Vec3{-0.4, -0.5, 0.8}}) {
    hp::FramePoint a, b;
    CHECK(hp::FrameDistance::of_static(world, soft, 0).nearest(x, 1, -1, a));
    CHECK(hp::FrameDistance::of_static(world, soft, 1).nearest(x, 1, -1, b));
    CHECK_NEAR(a.distance, b.distance, 1e-12);
    CHECK_NEAR(norm(a.n - b.n), 0, 1e-9);
    CHECK_NEAR(norm(a.at - b.at), 0, 1e-9);
    CHECK(!hp::FrameDistance::of_static(world, soft, 0).nearest(x, 0.9 * a.distance, -1, b));
  }
}

}  // namespace

int main() {
  points_have_the_force_moments_and_stiffness_of_the_samples();
  no_point_pulls();
  the_mean_rule_stores_what_it_takes();
  the_end_rule_is_the_law();
  surfaces_that_face_apart_are_patches();
  a_box_is_as_far_as_by_gjk();
  return check::report("condensation");
}
