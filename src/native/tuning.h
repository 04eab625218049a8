// Every tuning constant of the native core, each once (as in Jolt's PhysicsSettings.h).
//
// A tuning constant is a number that was chosen: a tolerance, a limit of iterations, a margin, a
// time, a speed. Not here: numbers of mathematics (pi, the number of vertices of a box), sizes of
// layouts (rows of four), and settings that a caller chooses (`Settings` of the package).
//
// Each states, in this order: what it is and its unit in brackets ([-] is left out for counts and
// ratios); what was measured to choose it, where it was; and what goes wrong below and beyond it.
// Measurements are told at length in docs/physics.md.
//
// Units are SI: [m], [s], [kg], [rad], [N s]. `2` at the end of a name means squared.
//
// Names are unique in the whole file, so that a name has one meaning. Code names the section: as
// `tuning::contact::kNewtonSteps`, or `tune::kNewtonSteps` after `namespace tune = tuning::contact;`.
// Python reads those that it shares from `halfphysics._native.tuning` (bindings/tuning.cpp): it never
// repeats a number.
#pragma once
#include <cstddef>

namespace hp::tuning::dynamics {

// Joints stop this far before their limits [rad or m]: rounding does not carry them beyond. It is
// far over the rounding of an angle of some turns; a million times more would be seen as a joint
// that does not reach its end.
constexpr double kLimitMargin = 1e-9;

// Half angles under this [rad] take sin(x)/x from its series, where the quotient loses digits: the
// first term that is left out is x^4/120, under the rounding of doubles up to 3e-4.
constexpr double kSeriesHalfAngle = 1e-4;

// Rotations whose vector part is shorter than this have the axis-angle vector 2 v: atan2(n, w)/n is
// 1 to rounding there, and at zero it does not exist.
constexpr double kNoRotation = 1e-12;

}  // namespace hp::tuning::dynamics

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::geometry {

// convex.cpp

// bvh.cpp

// triangle_cluster.h, triangle_tree.h

// point_queries.cpp

// Points that a thread takes at a time. Less, and threads meet at the counter; more, and the last
// thread works alone. Results do not depend on it.
constexpr size_t kPointBlock = 256;

// skinning.cpp

// Frames whose blend shapes are summed side by side: two registers of AVX2. Results do not depend on
// it: each frame's sums have one order.
constexpr int kSkinFrames = 8;

// Vertices per task of a thread. Less, and threads meet at the counter; more, and few frames leave
// threads without work. Results do not depend on it.
constexpr int kSkinChunk = 256;

}  // namespace hp::tuning::geometry

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::collision {

// Broad phase

// Narrow phase

// Contact points

// Clearances

// Self-contact

// Depenetration: the way out of what a motion starts inside of

}  // namespace hp::tuning::collision

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::contact {

// The problem of an island: rounds of sweeps and Newton steps (contact_problem.cpp). "Tolerance" is
// `Settings.tolerance` as a velocity [m/s].

// Sweeps of a round before Newton steps are tried: of many contacts a step costs many sweeps, so that
// three find the active set first; up to kFewContacts one is enough. Measured on a body pressed into
// a wall (Algorithm 1): one sweep for few contacts, and steps that may get worse (kNewtonMemory), took
// it from 818 to 1152 frames/s. Fewer: steps from a wrong active set fail; more: time.
constexpr int kRoundSweeps = 3, kRoundSweepsOfFew = 1, kFewContacts = 16;

// Sweeps and steps after which an island that aims finer than the tolerance is content with the
// tolerance itself, and after which kEnough tolerances do. What is left then is not worth more: the
// end pose of the substep is verified anyway. Larger: time where friction settles slowly.
constexpr int kFinePatience = 6, kTolerancePatience = 12;
constexpr double kEnough = 5;

// Rounds in a row that may bring nothing before the solve stops, and the factor under which the
// residual must fall for a round to bring something.
constexpr int kStalledRounds = 3;
constexpr double kRoundProgress = 0.5;

// Sweeps among the contacts of one pair before the others' velocities follow, and the share of the
// goal under which their impulses (times their inverse inertia) need not change to end them. The
// contacts of a pair lie close together and are the slowest to agree; more than three do not help
// while the rest of the island is unsolved.
constexpr int kPairSweeps = 3;
constexpr double kPairGoal = 0.1;

// Newton steps in a row, and how many of them may fail.
constexpr int kNewtonSteps = 20, kNewtonFailures = 2;

// Shares of a step that are tried, each half of the one before, and the part by which the merit must
// fall for a share to be taken. Rounding alone changes the merit by less.
constexpr int kNewtonShares = 8;
constexpr double kNewtonDecrease = 1e-3;

// Damping relative to the diagonal of the Delassus operator, its smallest value, and its factors after
// a step that failed and one that did not (Levenberg 1944, Marquardt 1963). Without damping the
// redundant points of a face make steps singular: 50 to 200 sweeps were needed where with it three
// sweeps and a few steps end. Too much: steps are short.
constexpr double kNewtonDamping = 1e-2, kNewtonLeastDamping = 1e-3;
constexpr double kNewtonMoreDamping = 5, kNewtonLessDamping = 0.3;

// A step need only be better than the worst of so many before it: the merit has curved valleys
// (Grippo, Lampariello, Lucidi 1986). The best of them is kept. With 1 (monotone) solves that miss the
// tolerance were 4.3 % of all on a body pressed into a wall, with 4 they are 1.1 %.
constexpr int kNewtonMemory = 4;

// Normal impulses alone, friction held, where nothing else ended (contact_problem.cpp).

// Rounds of that, each followed by the friction that the new normal impulses bear. From
// kFrictionRounds on, friction over its limit is dropped instead of reduced, so that the rounds end.
constexpr int kNormalRounds = 12, kFrictionRounds = 4;

// Changes of the active set in one round, and those that may bring no improvement before blocks of
// changes become single ones, which cannot cycle (Judice and Pires 1994).
constexpr int kPivots = 40, kBlockPivots = 3;

// The share of the tolerance to which they are solved: redundant points then agree among themselves.
constexpr double kNormalGoal = 1e-3;

// A contact leaves the active set if its impulse pulls by more than this share of the largest one.
// Redundant points trade rounding among themselves; at 0 that made them pivot without end.
constexpr double kPull = 1e-5;

// Multiplications after which no further round begins: about 0.1 s. A person inside a box took
// minutes a frame without a bound.
constexpr double kNormalWork = 1e8;

// Redundant points share what they carry as if they gave way by this share of their own inverse
// inertia: at 10 N s on a limb 4e-5 m/s, under the tolerance. Without it their pivots are singular.
constexpr double kCompliance = 1e-8;

// Rounding

// Added to the diagonal of a contact, as a share of its normal entry, and the least of those entries
// [1/kg]: contacts between immovable things would have a block of zeros.
constexpr double kDiagonalShare = 1e-12, kLeastInverseMass = 1e-9;

// Pivots of a Newton step that are smaller [1/kg] make it fail as singular.
constexpr double kSingularPivot = 1e-14;

// Pivots of the Cholesky factor are at least this share of the diagonal they come from.
constexpr double kCholeskyPivot = 1e-14;

// Impulses [N s] by which friction may be over its limit before it is dropped.
constexpr double kConeRounding = 1e-12;

// One contact on its own (coulomb.cpp).

// Newton steps on the direction of slip, the largest step [rad], and the step [rad] that ends them.
// Where several roots lie close together (near jamming) they do not end, and all directions are
// isolated as the roots of a polynomial instead.
constexpr int kSlipSteps = 8;
constexpr double kSlipLargestStep = 0.7, kSlipSettled = 1e-9;

// Whether friction opposes the slip is judged to this share of the contact's own scale. An absolute
// bound of 1e-12 let friction push along where inverse inertias or velocities are small.
constexpr double kSlipRounding = 1e-13;

// Directions in which a normal impulse gives less than this share of the normal entry of the operator
// are not taken from Newton's method: close to jamming another root may be the one.
constexpr double kSlipJamming = 1e-6;

// Halvings of an interval of [-1, 1] around a root: all bits of a double.
constexpr int kRootHalvings = 54;

// Islands and the contacts that take part (solver.cpp).

// Times that violated contacts may join those that take part. Larger costs time in piles; smaller
// leaves violations to the verification of the substep, which costs a pass.
constexpr int kJoinRounds = 12;

// Contacts that are violated by more than this share of the tolerance join: a corner that is left out
// sinks by as much in every substep. With a whole tolerance they did.
constexpr double kJoinShare = 1e-3;

// Tolerances that do while contacts may still join: the answer changes with every one of them.
constexpr double kRoughGoal = 10;

// Share of the tolerance to which objects among themselves are solved: what rests must not creep by
// what a tolerance allows. With a person in the island it would cost sweeps for nothing.
constexpr double kRestGoal = 1e-5;

// An island in which something on a track squeezes others is given up where a contact needs so many
// times the impulse that gives all that moves the largest velocity asked, or where normal velocities
// miss what is asked of them by so many tolerances: then there is no room, and the track must wait.
constexpr double kCrushing = 50, kUnsolved = 20;

}  // namespace hp::tuning::contact

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::stepping {

// The substep: planes, contacts, solve, verify, shorten or commit

// Sub-stepping

// Drive

// Kinematic bodies and held objects

// Strength, self-contact

// Depenetration, sleeping

}  // namespace hp::tuning::stepping

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::labels {

// Distances of a skin's vertices to a thing are known this much farther than the reach that is asked
// for [m], where points of the thing look for faces: a face may be in reach though its corners are
// not. Faces with longer edges than this are looked at one by one; the result does not depend on it.
constexpr double kBeyondReach = 0.1;

// The same without such points: what may be missed by rounding [m].
constexpr double kReachRounding = 1e-6;

// Cells of the grid of points along its longest side. Fewer: more points per question; more: memory,
// and cells that are empty. Results do not depend on it.
constexpr int kGridCells = 48;

}  // namespace hp::tuning::labels

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::render {

// Width and height of a tile [pixels]. Smaller: triangles are sorted into more tiles; larger: fewer
// tasks for threads, and layers that do not fit the cache. Results do not depend on it.
constexpr int kTile = 32;

// A corner on the grid of samples is rounded to one of so many steps: edges of neighbouring triangles
// then meet without a crack, and products of coordinates fit 64 bits within the guard band.
constexpr long long kStepsPerSample = 256;

// Half width of the guard band, in pictures: triangles are clipped to it, not to the picture.
constexpr double kGuardBand = 8;

// A shadow's edge spans 2 kShadowTaps + 1 texels, which is the light's softness. More: slower, and
// shadows of thin things fade.
constexpr int kShadowTaps = 3;

// Texels along the longer side of a shadow map, at most: 16 MB of it. Wide scenes have blurrier
// shadows instead.
constexpr int kMostTexels = 2048;

// Steps of linear light in the table that turns it into sRGB bytes: no step of 8 bits is missed.
constexpr int kEncoderSteps = 1 << 14;

}  // namespace hp::tuning::render
