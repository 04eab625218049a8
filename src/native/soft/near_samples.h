// The samples of one shape that may reach one layer in a step: one array for each number, in the order of samples.
// Loops over them read only the numbers that they need, several samples at a time.
#pragma once
#include <vector>

#include "math/vec.h"
#include "soft/foam_cells.h"
#include "soft/soft_law.h"

namespace hp {

class NearSamples {
 public:
  enum Column {
    // The law of both layers (soft_law.h).
    Stiffness,
    Damping,
    Densification,
    Arm,
    Relaxation,
    Own,        // thickness of the sample's own layer [m]
    Surface,    // the area that it stands for [m^2]
    HalfWidth,  // half of the root of that [m]
    Normal,     // outward, unit; of a skin: at the start of the step
    Before = Normal + 3,
    First,             // where the point above it was at the start of the step
    Gone = First + 3,  // q of the Maxwell arm then [m]
    Stored,            // energy then [J]; of a skin it is not known
    Slack,             // how far beyond both thicknesses it may be pressed [m]
    Room,              // how far it was from there at the start, at least [m]
    // Of its hard point, at the pose that it was measured at last:
    Hard,               // where it is
    Away = Hard + 3,    // from the nearest point of the frame to it, unit
    At = Away + 3,      // that nearest point
    Distance = At + 3,  // how far it is [m]
    LayerThickness,     // above that point [m]
    // Of the pose looked at last:
    Depth,      // d [m]
    Edge,       // e [m]
    Thickness,  // t of the law: of both layers [m]
    Area,       // as the layer sees it [m^2]; 0: it is not pressed
    // Of the step that ends there:
    Pressure,     // [Pa]
    ArmPressure,  // p_m [Pa], over the share of the sample that is pressed
    Pressed,      // that share
    Slope,        // of the pressure by the depth at the end [Pa/m]
    Went,         // how far the dashpot of the Maxwell arm goes [m]; known when the step is made
    Columns,
  };

  int size() const { return (int)sample.size(); }
  bool empty() const { return sample.empty(); }
  void clear();
  double* operator[](Column c) { return numbers_.data() + (size_t)c * room_; }
  const double* operator[](Column c) const { return numbers_.data() + (size_t)c * room_; }
  // Of columns of three.
  Vec3 vector(Column c, int i) const {
    const double* x = (*this)[c] + i;
    return {x[0], x[room_], x[2 * room_]};
  }
  void set(Column c, int i, Vec3 v) {
    double* x = (*this)[c] + i;
    x[0] = v.x, x[room_] = v.y, x[2 * room_] = v.z;
  }
  SoftLaw law(int i) const;
  void set_law(int i, const SoftLaw& law);

  // Zeros behind the last sample, as far as loops over several at a time go.
  void end(Column c);

  // Appends one whose numbers are 0; returns where it is.
  int add(int number);
  // Those at these places alone, in this order.
  void keep(const std::vector<int>& places);

  // Room for four numbers of each sample; kept until the next call.
  double* rows() {
    rows_.resize(4 * sample.size());
    return rows_.data();
  }

  std::vector<int> sample;
  std::vector<int> triangle;   // of a mesh: for the next search nearby to begin with, or -1
  std::vector<char> measured;  // it was within reach where it was measured last
  std::vector<char> celled;    // and `cell` is that of this place
  std::vector<FoamPlace> cell;

 private:
  std::vector<double> numbers_, spare_, rows_;
  size_t room_ = 0;  // of each column
};

}  // namespace hp
