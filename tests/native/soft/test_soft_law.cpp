// The law of a layer, and what its foam remembers.
#include <cmath>

#include "check.h"
#include "soft/foam_cells.h"

namespace {

using hp::Vec3;

hp::SoftLaw foam() {
  hp::SoftLaw law;
  law.stiffness = 2e5, law.damping = 800, law.densification = 4, law.arm = 0.5;
  law.relaxation = 0.8;
  return law;
}

// Slope, energy and its sum are derivative and integrals of the pressure.
void energies_are_integrals() {
  const hp::SoftLaw law = foam();
  const double t = 0.1, e = 1e-6;
  for (const double d : {0.002, 0.03, 0.07, 0.1}) {
    CHECK_NEAR((law.pressure(d + e, t) - law.pressure(d - e, t)) / (2 * e), law.slope(d, t),
               1e-6 * law.slope(d, t));
    CHECK_NEAR((law.energy(d + e, t) - law.energy(d - e, t)) / (2 * e), law.pressure(d, t),
               1e-6 * law.pressure(d, t));
    CHECK_NEAR((law.energy_sum(d + e, t) - law.energy_sum(d - e, t)) / (2 * e), law.energy(d, t),
               1e-6 * law.energy(d, t));
  }
  CHECK(law.pressure(-0.01, t) == 0 && law.energy(0, t) == 0);
}

// It starts with k and ends, fully compressed, 1 + D times as hard.
void foam_stiffens() {
  const hp::SoftLaw law = foam();
  CHECK_NEAR(law.pressure(1e-4, 0.1) / 1e-4, 2e5, 1);
  CHECK_NEAR(law.pressure(0.1, 0.1) / 0.1, 5 * 2e5, 1e-6);
}

void layers_are_springs_in_series() {
  hp::SoftLaw skin;
  skin.stiffness = 6e5, skin.damping = 1600;
  const hp::SoftLaw both = hp::in_series(foam(), skin);
  CHECK_NEAR(1 / both.stiffness, 1 / 2e5 + 1 / 6e5, 1e-20);
  CHECK_NEAR(1 / both.damping, 1 / 800.0 + 1 / 1600.0, 1e-12);
  CHECK_NEAR(both.densification, 4 * 0.75, 1e-12);  // the foam takes three quarters of the depth
  const hp::SoftLaw hard;
  CHECK(hp::in_series(hard, skin).stiffness == 6e5);
}

// Cells where the caller has them in mind, in the wrong place or not: it changes no answer.
hp::FoamPlace at(int layer, Vec3 x, int found = 7) {
  return {hp::FoamCell::around(layer, x), found};
}

double gone(const hp::FoamCells& cells, hp::FoamPlace place, const hp::SoftLaw& law) {
  return cells.gone(law.relaxation * (1 + law.arm), place);
}

void press(hp::FoamCells& cells, hp::FoamPlace place, double q, double area) {
  cells.press(q, area, place);
}

void a_cell_goes_back_as_an_exponential() {
  const hp::SoftLaw law = foam();
  hp::FoamCells cells;
  press(cells, at(0, {0.001, 0.001, 0}), 0.04, 1e-4);
  press(cells, at(0, {0.002, 0.003, 0}), 0.06, 3e-4);
  cells.end_step(0.01);
  CHECK_NEAR(gone(cells, at(0, {0.0015, 0.001, 0}), law), 0.055, 1e-15);  // the mean by area
  CHECK(gone(cells, at(1, {0.0015, 0.001, 0}), law) == 0);                // another layer
  CHECK(gone(cells, at(0, {0.1, 0.001, 0}), law) == 0);                   // another place
  for (int k = 0; k < 60; k++) cells.end_step(0.02);
  CHECK_NEAR(gone(cells, at(0, {0, 0, 0}), law), 0.055 * std::exp(-1.2 / (0.8 * 1.5)), 1e-12);
}

// More cells than the table began with, forgotten one by one: those that are left are found.
void cells_come_and_go() {
  const hp::SoftLaw law = foam();
  hp::FoamCells cells;
  const auto place = [](int i) { return Vec3{0.02 * (i % 20), 0.02 * (i / 20), 0}; };
  for (int i = 0; i < 400; i++) press(cells, at(0, place(i), -1), 1e-3 * (i + 1), 1e-4);
  cells.end_step(0.01);
  for (int i = 0; i < 400; i += 3) press(cells, at(0, place(i)), 0, 1e-4);
  cells.end_step(0);
  for (int i = 0; i < 400; i++) {
    CHECK_NEAR(gone(cells, at(0, place(i), 400 - i), law), i % 3 == 0 ? 0 : 1e-3 * (i + 1), 1e-15);
  }
}

void memory_is_saved() {
  hp::FoamCells cells, other;
  press(cells, at(-2, {-0.05, 0.4, 7}), 0.03, 1e-4);
  cells.end_step(0.01);
  std::vector<double> state;
  cells.save(state);
  CHECK(other.load(state.data()) == state.data() + state.size());
  CHECK_NEAR(gone(other, at(-2, {-0.05, 0.4, 7}), foam()), 0.03, 0);
}

}  // namespace

int main() {
  energies_are_integrals();
  foam_stiffens();
  layers_are_springs_in_series();
  a_cell_goes_back_as_an_exponential();
  cells_come_and_go();
  memory_is_saved();
  return check::report("soft_law");
}
