// Layer load: whom soft layers carry, its weight presses on them.
//
// A drive leaves no velocity to gravity, and contacts alone would push a person up out of a cushion. While layers carry
// it (footing/on_layers.h) the height of the root is free: it is driven with the velocity of the motion, but to no
// target, deviations up and down decay at the rate r = kLayerDamping (kWadeDamping on its feet), and all of its bodies
// have the share w of their weight:
//
//   v*_z = v_ref,z + exp(-r h) e_z - h w g / s,    e_z -= w (M dv_ref)_z / m as a frame begins
//
// so that layers carry w m (g + a), a the acceleration that the motion, dv_ref a frame, gives the centre of mass: who
// lands on them sinks deeper than who stands.
// With M^ = s (M + ...) the term of gravity is exactly the generalised force w M e_z g, on limbs too. What drives
// joints takes no momentum from nowhere, and who rests is turned and shifted by layers and feet alone (layer_balance.h).
//
// M^ lets the person be s times as heavy for what pushes it. As a substep ends, with P the impulses that have pushed the
// person upwards in it, the root's velocity gets the rest of them and of gravity,
//
//   v_z += (1 - 1/s) (P/m - h w g)
//
// so that a person bounces as its mass has it, with any number of substeps. Something hard throws nobody up: where it
// has pushed, a rise is that of the layers' part of P alone.
//
// At rest e = 0 and v = 0: then M^ (0 - v*) = sum J^T p, and the normal forces of the layers sum to w m g, whatever
// their laws, the frame rate or the substeps.
#pragma once
#include "stepping/data.h"

namespace hp {

// Adds the weight to step.v_free of a substep of length h, after limits of strength.
void add_layer_load(System& system, Data& data, double h);
// What w g makes of the root's velocity in a substep, upwards [m/s]: h w g / s, with s that of the drive.
double layer_fall(const System& system, const Drive& d, double h);
// The frame of all who are stepped through begins, after Drive::begin_frame().
void begin_layer_frame(System& system, Data& data);
// A substep of length h has ended with state.qvel, which is changed; what drives exert is known.
void end_layer_substep(System& system, Data& data, double h);
// After a frame of length dt: with how much layers have pressed, and where.
void end_layer_frame(System& system, const FrameResult& result, double dt);

}  // namespace hp
