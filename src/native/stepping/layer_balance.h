// Layer balance: whom soft layers carry, they and the feet hold it, and nothing else.
//
// A drive turns and moves the root with forces from nowhere. Somebody who rests on layers has none of these: with
// r = OnLayers::rest(), 0 while the root moves and 1 once it is still, the root's v* is (1 - r) times that of the
// drive and r times that of a body which is free:
//
//   v* = v_ref + exp(-k h) e + y + h/s (I^-1 N, about the centre of mass),     k = kLayerDamping
//
// y makes what joints do internal: with x_J the change of the joints' velocities by the drive, M_rr y = -(M x_J)_r, so
// that neither momentum nor angular momentum of the person comes from nowhere. (Of who moves only the momentum
// up and down is made so.)
// N is the moment of the feet that stand on hard ground, whose force is F = N_f m g at x_f,
//
//   N_f = legs + (N_s . u)/(m g l),   N = m g N_f l u + (roll),   l u = (x_f - x_com) x z
//
// `legs` is what hangs on feet if legs do nothing (shank, foot and half of the thigh), N_s = -I kSeatedRate^2 xi a weak
// spring back to the motion's orientation, limited to what feet can do: they push up, by kMostOnFeet at most, and their
// breadth times F about the other axis. Layers have the rest of the weight: w = 1 - N_f. Without feet on the ground
// nothing supplies the spring, which is too weak to matter. So at rest forces and moments of layers and feet sum to nothing
// with the weight, and the person turns until they do: somebody upright with the feet on nothing leans until the pressure
// under its seat and thighs is below its centre of mass. A narrow cushion would let it fall over: from kLeansFreely
// on, wholly from kLeansHeld on, the drive holds who sits upright so, and that moment is held by nothing. So it does with
// who squats over feet that stand in a layer.
#pragma once
#include "stepping/data.h"

namespace hp {

// Changes the root's rows of step.v_free of somebody whom layers carry, but for the weight.
void balance_on_layers(System& system, Data& data, Drive& d, double h);

}  // namespace hp
