// Shared by the files that expose something to Python: each defines one bind_* function.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

namespace nb = nanobind;

// C-contiguous float64 / int32 arrays on the CPU, any of the given shapes (-1: any length).
template <typename... Shape>
using f64 = nb::ndarray<const double, nb::c_contig, nb::device::cpu, Shape...>;
template <typename... Shape>
using i32 = nb::ndarray<const int, nb::c_contig, nb::device::cpu, Shape...>;

void bind_physics(nb::module_& m);
void bind_tuning(nb::module_& m);
void bind_skinning(nb::module_& m);
void bind_triangle_tree(nb::module_& m);
void bind_touching(nb::module_& m);
void bind_gaps(nb::module_& m);
void bind_part_balls(nb::module_& m);
void bind_wrench_spread(nb::module_& m);
void bind_coordinates(nb::module_& m);
void bind_world_file(nb::module_& m);
