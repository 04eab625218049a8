// Whether the arrays of a model describe trees of bodies, whoever made them.
#pragma once
#include "dynamics/kinematic_tree.h"

namespace hp::assembly {

// Before Model::finish(). Throws std::invalid_argument unless all arrays are of the model's sizes, bodies, joints,
// coordinates and dofs follow each other without a gap, and masses and moments are not negative.
void check_model(const Model& m);

}  // namespace hp::assembly
