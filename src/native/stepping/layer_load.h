// Layer load: whom soft layers carry, its weight presses on them.
//
// A drive leaves no velocity to gravity, and contacts alone would push a person up out of a cushion. While layers carry
// it (footing/on_layers.h) the height of the root is free: it is driven with the velocity of the motion, but to no
// target, deviations up and down decay at the rate r = kLayerDamping, and all of its bodies have the share w of
// their weight:
//
//   v*_z = v_ref,z + exp(-r h) e_z - h w g / s,    e_z -= w (change of v_ref,z) as a frame begins
//
// so that layers carry w m (g + a), a the motion's acceleration: who lands on them sinks deeper than who stands.
// With M^ = s (M + ...) the last term is exactly the generalised force w M e_z g of gravity, on limbs too. What drives
// joints takes no momentum from nowhere, and who rests is turned and shifted by layers and feet alone (layer_balance.h).
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
// After a frame of length dt: with how much layers have pressed, and where.
void end_layer_frame(System& system, const FrameResult& result, double dt);

}  // namespace hp
