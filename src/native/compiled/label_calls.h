// The calls of a world file that fill in Labels. Each throws std::invalid_argument where arrays do not fit; check_world()
// (world_check.h) compares with the stepper at the end.
#pragma once
#include "compiled/labels.h"

namespace hp {

// `names`: of everything, each followed by a zero byte.
void label_everything(Labels& labels, std::string names, std::vector<int> shape_name,
                      std::vector<int> shape_part, std::vector<int> static_name);
void label_person(Labels& labels, std::string name, int root, int qpos, Ints joint_qpos, Ints body,
                  Ints ball, Doubles rest_pelvis, Square axes, Doubles pelvis, Doubles stiffness);
void label_object(Labels& labels, std::string name, int body, int qpos, int dof, Doubles com,
                  Square inertia, bool pushable);
void label_link(Labels& labels, std::string name, int body);
void label_joint(Labels& labels, std::string name, int qpos, int width);
void label_start(Labels& labels, Doubles qpos, Doubles qvel, int substeps);
void label_friction(Labels& labels, Doubles own, std::vector<int> pair);

}  // namespace hp
