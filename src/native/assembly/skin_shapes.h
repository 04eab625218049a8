// A person's skin and the hulls that collide, derived once: steppers in which the person's bodies
// have the same numbers share them.
#pragma once
#include <memory>
#include <vector>

#include "assembly/array_view.h"
#include "collision/collision_shape.h"

namespace hp::assembly {

struct SkinShapes {
  std::shared_ptr<const Skin> skin;
  std::vector<CollisionShape> shapes;
};

// `body`, `dof`: of every joint its body and first dof in the model. Vertex v has the weights first[v] ...
// first[v + 1] - 1, of the joints `at`. `bend`: (vertices, 3, features), or of no vertices: no pose blend
// shapes. Hull h has the vertices vertex[start[h]] ... vertex[start[h + 1] - 1] and belongs to part[h].
// Throws std::invalid_argument where the arrays do not fit together.
SkinShapes skin_shapes(Ints body, Ints dof, Ints parent, Rows3 joint, Rows3 rest, Ints first,
                       Ints at, Doubles weight, Cube bend, Ints part, Ints start, Ints vertex);

}  // namespace hp::assembly
