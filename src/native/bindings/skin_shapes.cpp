// A person's skin and its hulls, derived once for all steppers of the person.
#include "assembly/skin_shapes.h"
#include "bindings/stepper.h"

using namespace hp;
using namespace hp::assembly;

void bind_skin_shapes(nb::module_& m) {
  using namespace nb::literals;
  nb::class_<SkinShapes>(m, "SkinShapes")
      .def(
          "__init__",
          [](SkinShapes* self, Ints body, Ints dof, Ints parent, Rows3 joint, Rows3 rest,
             Ints first, Ints at, Doubles weight, Cube bend, Ints part, Ints start, Ints vertex) {
            new (self) SkinShapes(skin_shapes(body, dof, parent, joint, rest, first, at, weight,
                                              bend, part, start, vertex));
          },
          nb::kw_only(), "body"_a, "dof"_a, "parent"_a, "joint"_a, "rest"_a, "first"_a, "at"_a,
          "weight"_a, "bend"_a, "part"_a, "start"_a, "vertex"_a)
      .def("__len__", [](const SkinShapes& s) { return s.shapes.size(); });
}
