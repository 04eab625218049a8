// What is soft, given as arrays: layers above hard frames, and the points by which things press on them.
// After the static or the shape that a call is about, before finish. All throw std::invalid_argument
// where numbers are out of range or arrays do not fit. Numbers are those of soft/soft_law.h.
#pragma once
#include <string>

#include "assembly/array_view.h"
#include "stepping/stepper.h"

namespace hp::assembly {

// A layer on the last static added: `law` is "linear" or "foam", `thickness` [m], `stiffness` [Pa/m],
// `damping` [Pa s/m], `densification`, `arm`, `relaxation` [s]. `corners` (faces, 3) [m]: the thickness at
// the corners of a mesh's faces, in the order of the faces; (0, 3): `thickness` everywhere.
void set_soft_static(Stepper& s, const std::string& law, double thickness, double stiffness,
                     double damping, double densification, double arm, double relaxation,
                     Rows3 corners);
// The same on the last shape added.
void set_soft_shape(Stepper& s, const std::string& law, double thickness, double stiffness,
                    double damping, double densification, double arm, double relaxation);
// Samples of the hard surface of the last rigid shape added, in its body's frame: points [m], outward
// unit normals, and areas [m^2].
void set_samples(Stepper& s, Rows3 points, Rows3 normals, Doubles areas);
// Samples of a person's skin: vertices of the skin, areas [m^2], outward unit normals at rest, the joint of the
// part that each belongs to, and the layer of skin above each: thickness [m] (0: hard), stiffness
// [Pa/m] and damping [Pa s/m].
void set_skin_samples(Stepper& s, int person, Ints vertices, Doubles areas, Rows3 normals,
                      Ints parts, Doubles thickness, Doubles stiffness, Doubles damping);

}  // namespace hp::assembly
