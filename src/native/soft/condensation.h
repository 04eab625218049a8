// The pressure of one pair, or of all pairs of one body and one layer, as a few compliant contact points.
//
// Samples whose layers face the same way make a patch; there are up to kMostPatches of them. In a patch, with
// q_i the impulse of sample i [N s], S_i = -dq_i/dw its change by the velocity w at which the two part
// [kg], and x_i its place: the sums Q and S, the centres x_Q and x_S, and the second moments of the S_i
// about x_S in the patch's plane, with principal axes e1, e2 and standard deviations s1, s2. The points are
//
//     x_j = x_S +- s1 e1 +- s2 e2,   S_j = S/4,
//     q_j = Q/4 (1 +- a1 +- a2),     a_k = (x_Q - x_S).e_k / s_k
//
// which have the force, both moments, and all of their derivatives by a rigid motion of the patch (two points
// where the patch is a line, one where it is a point). If some q_j were negative, the points lie about x_Q, with equal q_j.
//
// Each point is a row of the solver with a compliance: q = max(0, q_j + S_j (w_j - w)).
#pragma once
#include <vector>

#include "soft/pressed_samples.h"
#include "soft/pressing.h"

namespace hp {

// Appends the samples of a pair that are under pressure, by what was found last, where the samples are. With
// Rule::Mean, whose samples have been measured at the end, impulses act at the means of the places about the
// shape's middle at the start and at the end, which has gone `way`. The way along the layer that a turn makes is then that of the
// velocity there, and the work of the pressures is the energy of the springs; places of one end alone would
// give a turning thing h/2 of the pressure's work too much.
void list_pressed(const SoftPair& pair, int member, Rule rule, double h, Vec3 way,
                  PressedSamples& out);

struct PatchPoint {
  Vec3 x, n;
  double impulse = 0;  // q_j [N s]
  double yield = 0;    // S_j [kg]
  int patch = 0;
  int member = 0;  // of the sample of the patch that is pressed most
};

// What the samples of a group push with in a step, all together.
struct PairImpulse {
  Vec3 force, moment;  // impulses [N s], and about `about` [N m s]
  double size = 0;     // sum of the samples' impulses [N s]
  double lever = 0;    // their mean distance from there [m]
};

// Impulses that move the step, of all samples that list_pressed() would list.
PairImpulse total_impulse(const std::vector<const SoftPair*>& pairs, Rule rule, double h, Vec3 way,
                          Vec3 about);
// The points of all patches, appended to `out`; samples get the number of theirs.
// `least_turn` [kg m^2]: no points are made of a spread that resists turning by less, S s^2.
void condense(PressedSamples& pressed, double least_turn, std::vector<PatchPoint>& out);

}  // namespace hp
