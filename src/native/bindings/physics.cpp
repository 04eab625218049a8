// The Python face of the stepper. Arrays are copied in once.
#include "bindings/stepper.h"

using namespace hp;
using hp::assembly::MeshTree;

void bind_physics(nb::module_& m) {
  nb::class_<MeshTree>(m, "MeshTree")
      .def("__init__",
           [](MeshTree* self, Rows3 vertices, Faces faces) {
             std::shared_ptr<const TriangleTree> tree;
             {
               nb::gil_scoped_release release;
               tree = TriangleTree::shared(vertices.data(), (int)vertices.shape(0), faces.data(),
                                           (int)faces.shape(0));
             }
             new (self) MeshTree{std::move(tree)};
           })
      .def("__len__", [](const MeshTree& t) { return t.tree->size(); })
      // Number of holders of the tree, this one included.
      .def_prop_ro("shares", [](const MeshTree& t) { return t.tree.use_count(); });

  bind_skin_shapes(m);

  StepperClass stepper(m, "Stepper");
  stepper.def(nb::init<>());
  bind_stepper_system(stepper);
  bind_stepper_shapes(stepper);
  bind_stepper_frames(stepper);
  bind_stepper_results(stepper);
  bind_probes(m, stepper);
  bind_batch(m);
  bind_hosted_world(m);
  bind_fleet(m);
}
