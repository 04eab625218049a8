// Pressures of samples from their depths. Equations: pressing.h, soft_law.h.
#pragma once
#include "soft/near_samples.h"

namespace hp {

// The start of a step: depths, and what is kept of them.
void start_step(NearSamples& near);
// Depth, edge, thickness and area of all samples, by their normals and as they were measured last.
void face(NearSamples& near);
// Depths where each sample has gone on for h [s] with the twist (v, w about the origin) relative to the layer, from
// where it was at the start.
void go_on(double h, Vec3 v, Vec3 w, NearSamples& near);
// The pressures of a step of length h [s] to those depths, by each rule.
void press_to_end(double h, NearSamples& near);
void press_by_mean(double h, NearSamples& near);

// How far the dashpots of the Maxwell arms go in that step.
void find_went(double h, NearSamples& near);
// Energies at the start of a step, where samples are faced.
void store(NearSamples& near);
// The energy that springs have given back in a step since then, less what their dampers have taken [J]; after
// find_went().
double given_back(double h, const NearSamples& near);

}  // namespace hp
