#include "compiled/replay.h"

#include <stdexcept>
#include <string_view>

#include "assembly/limit_calls.h"
#include "assembly/shape_calls.h"
#include "assembly/soft_calls.h"
#include "assembly/system_calls.h"
#include "compiled/arguments.h"
#include "compiled/label_calls.h"
#include "compiled/world_check.h"

namespace hp {

namespace {

using namespace assembly;

void add_skin(Stepper& s, Ints body, Ints dof, Ints parent, Rows3 joint, Rows3 rest, Ints first,
              Ints at, Doubles weight, Cube bend, Ints part, Ints start, Ints vertex, int person,
              Ints names) {
  need(body.shape(0) == kJoints, "a skin has 55 joints");
  add_skin_shapes(
      s, skin_shapes(body, dof, parent, joint, rest, first, at, weight, bend, part, start, vertex),
      person, names);
}

void add_triangles(Stepper& s, int name, Rows3 vertices, Faces faces) {
  add_mesh(s, name,
           {TriangleTree::shared(vertices.data(), (int)vertices.shape(0), faces.data(),
                                 (int)faces.shape(0))});
}

// When a call may be made; they come in this order.
enum class Phase { Model, Shapes, Finish, Limits, Labels };

using Run = void (*)(CompiledWorld&, const Arguments&, const char* const*);

template <auto F, typename... A, size_t... I>
void run(CompiledWorld& world, const Arguments& arguments, const char* const* names,
         void (*)(Stepper&, A...), std::index_sequence<I...>) {
  F(world.stepper, arguments.get<std::decay_t<A>>(names[I])...);
}
template <auto F, typename... A, size_t... I>
void run(CompiledWorld& world, const Arguments& arguments, const char* const* names,
         void (*)(Labels&, A...), std::index_sequence<I...>) {
  F(world.labels, arguments.get<std::decay_t<A>>(names[I])...);
}
template <typename T, typename... A>
constexpr size_t count(void (*)(T&, A...)) {
  return sizeof...(A);
}
template <auto F>
void call(CompiledWorld& world, const Arguments& arguments, const char* const* names) {
  run<F>(world, arguments, names, F, std::make_index_sequence<count(F)>());
}

struct Entry {
  std::string_view name;
  Phase phase;
  Run run;
  const char* arguments[20];  // in the order of the function
};

// The names that simulation/call_recorder.py writes.
constexpr Entry kCalls[] = {
    {"set_model",
     Phase::Model,
     call<&set_model>,
     {"parent", "jnt_first", "jnt_count", "dof_first", "dof_count", "pos", "quat", "ipos", "iquat",
      "mass", "inertia", "jnt_type", "jnt_qpos", "jnt_dof", "jnt_body", "jnt_pos", "jnt_axis",
      "qpos0", "armature"}},
    {"set_joint_forces",
     Phase::Shapes,
     call<&set_joint_forces>,
     {"damping", "stiffness", "spring", "limited", "range"}},
    {"add_shape",
     Phase::Shapes,
     call<&add_shape>,
     {"body", "name", "person", "part", "vertices", "normals", "radius", "rim"}},
    {"set_slack", Phase::Shapes, call<&set_slack>, {"slack"}},
    {"add_skin_shapes",
     Phase::Shapes,
     call<&add_skin>,
     {"body", "dof", "parent", "joint", "rest", "first", "at", "weight", "bend", "part", "start",
      "vertex", "person", "names"}},
    {"add_half_space", Phase::Shapes, call<&add_half_space>, {"name", "normal", "offset"}},
    {"add_hull", Phase::Shapes, call<&add_hull>, {"name", "vertices", "normals", "radius", "rim"}},
    {"add_mesh", Phase::Shapes, call<&add_triangles>, {"name", "vertices", "faces"}},
    {"set_soft_static",
     Phase::Shapes,
     call<&set_soft_static>,
     {"law", "thickness", "stiffness", "damping", "densification", "arm", "relaxation", "corners"}},
    {"set_soft_shape",
     Phase::Shapes,
     call<&set_soft_shape>,
     {"law", "thickness", "stiffness", "damping", "densification", "arm", "relaxation"}},
    {"set_samples", Phase::Shapes, call<&set_samples>, {"points", "normals", "areas"}},
    {"set_skin_samples",
     Phase::Shapes,
     call<&set_skin_samples>,
     {"person", "vertices", "areas", "normals", "parts", "thickness", "stiffness", "damping"}},
    {"set_pairings", Phase::Shapes, call<&set_pairings>, {"friction", "restitution", "ignore"}},
    {"set_drive",
     Phase::Shapes,
     call<&set_drive>,
     {"time_constant", "recovery_rate", "recover_root", "root_speed"}},
    {"set_contact",
     Phase::Shapes,
     call<&set_contact>,
     {"clearance", "clearance_range", "depenetration_speed", "tolerance", "max_sweeps", "gravity"}},
    {"set_baselines",
     Phase::Shapes,
     call<&set_baselines>,
     {"internal_forces", "joint_damping", "torque_frequency", "torque_damping"}},
    {"set_prescribed", Phase::Shapes, call<&set_prescribed>, {"how"}},
    {"add_trajectory",
     Phase::Shapes,
     call<&add_trajectory>,
     {"body", "fps", "loop", "position", "turn"}},
    {"start_asleep", Phase::Shapes, call<&start_asleep>, {"body"}},
    {"finish", Phase::Finish, call<&finish>, {"roots"}},
    {"set_strength", Phase::Limits, call<&set_strength>, {"person", "limits"}},
    {"set_joint_ranges",
     Phase::Limits,
     call<&set_joint_ranges>,
     {"person", "axes", "lower", "upper"}},
    {"set_waiting", Phase::Limits, call<&set_waiting>, {"on"}},
    {"set_footing",
     Phase::Limits,
     call<&set_footing>,
     {"person", "joints", "soles", "hands", "body", "weight", "local", "normal"}},
    {"set_self_pairs", Phase::Limits, call<&set_self_pairs>, {"pairs"}},
    {"label_everything",
     Phase::Labels,
     call<&label_everything>,
     {"names", "shape_name", "shape_part", "static_name"}},
    {"label_person",
     Phase::Labels,
     call<&label_person>,
     {"name", "root", "qpos", "joint_qpos", "body", "ball", "rest_pelvis", "axes", "pelvis",
      "stiffness"}},
    {"label_object",
     Phase::Labels,
     call<&label_object>,
     {"name", "body", "qpos", "dof", "com", "inertia", "pushable"}},
    {"label_link", Phase::Labels, call<&label_link>, {"name", "body"}},
    {"label_joint", Phase::Labels, call<&label_joint>, {"name", "qpos", "width"}},
    {"label_start", Phase::Labels, call<&label_start>, {"qpos", "qvel", "substeps"}},
    {"label_friction", Phase::Labels, call<&label_friction>, {"own", "pair"}},
};

const Entry& entry(std::string_view name) {
  for (const Entry& e : kCalls)
    if (e.name == name) return e;
  throw std::invalid_argument(
      "world file: there is no call " + std::string(name) +
      "; write the file with the same version of halfphysics as this library");
}

}  // namespace

std::unique_ptr<CompiledWorld> read_world(const void* bytes, size_t size) {
  const WorldFile file(bytes, size);
  auto world = std::make_unique<CompiledWorld>();
  world->checksum = file.checksum();
  Phase phase = Phase::Model;
  bool modelled = false, finished = false;
  for (const RecordedCall& recorded : file.calls()) {
    const Entry& e = entry(recorded.name);
    const bool again = e.phase == Phase::Model ? modelled : e.phase == Phase::Finish && finished;
    if (e.phase < phase || again || (e.phase > Phase::Model && !modelled) ||
        (e.phase > Phase::Finish && !finished))
      throw std::invalid_argument("world file: " + std::string(recorded.name) +
                                  " is out of order; write the file again with save_world");
    if (e.phase == Phase::Finish) check_before_finish(world->stepper.system);
    e.run(*world, Arguments(recorded), e.arguments);
    phase = e.phase;
    modelled = true;
    finished |= e.phase == Phase::Finish;
  }
  need(finished, "world file: it ends before the world is whole; write it again with save_world");
  check_world(*world);
  return world;
}

}  // namespace hp
