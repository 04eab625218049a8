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
// Python reads those that it shares from `halfphysics._native.tuning` (bindings/tuning.cpp) instead
// of repeating the number.
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

// Axes of a joint's range may miss unit length and right angles by this: rounding.
constexpr double kFrameRounding = 1e-9;
// The twist of a joint counts where the w of its swing exceeds this: swings up to 157 degrees. Nearer to
// 180, where there is no twist, its rate grows without bound.
constexpr double kLeastTwistShare = 0.2;

// Ancestors of all degrees of freedom together, of which there is a list: 64 MiB. A person has
// some 4,000; of a stranger's chain of thousands of links it would fill the memory.
constexpr size_t kMostAncestors = size_t{1} << 24;

}  // namespace hp::tuning::dynamics

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::geometry {

// Distances of convex shapes (gjk.cpp, separation.cpp, bvh.cpp)

// Iterations of GJK: a bound against endless cycles by rounding. A search that ends by it reports a
// distance that is too large by what it had not converged.
constexpr int kGjkIterations = 64;
// Relative progress of the squared distance under which the search ends: some rounding errors.
constexpr double kGjkProgress = 1e-13;
// The same of a search that features end (disc_distance.h), and rounding of its support points relative
// to their coordinates; steps of Newton's method for a line and the rim, which takes three or four, the
// share of the distance that it may miss, and the slope under which it is not tried.
constexpr double kDiscProgress = 1e-12, kDiscRounding = 1e-15;
constexpr int kDiscSteps = 12;
constexpr double kDiscMiss = 1e-12, kLeastSlope = 1e-3;
// Support points nearer than 0.01 pm are the same; points of the simplex nearer than 0.01 nm to the
// origin are at it [m^2].
constexpr double kSameSupport2 = 1e-28, kAtOrigin2 = 1e-22;
// A distance that a separating direction proves to exceed this is no rounding [m].
constexpr double kProvedApart = 1e-9;
// A line between nearest points that is shorter than this may be tilted, or point anywhere, by the
// rounding of coordinates of some metres (1e-15) over its length [m]: the direction of shapes that rest
// on each other. It counts only if it separates them to within the second distance.
constexpr double kTouching = 1e-5, kSeparates = 1e-6;
// Shapes nearer than this take the normal of a face [m] if it separates them as well, to within the
// second distance: friction on a plane that is tilted by rounding creeps.
constexpr double kNearFaces = 2e-3, kSameDistance = 1e-7;
// A face is tried if the cosine of its normal to the line between nearest points exceeds this: of
// shapes that touch, and of others. Less, and a face beside an edge could take the place of the edge.
constexpr double kLikeTouching = 0.9, kLikeNear = 0.9999;

// Pairs of points that bound what a direction can be worth (direction_bounds.h), and the rounding that a
// bound must be under by [m]. No result depends on them.
constexpr int kBoundPairs = 8;
constexpr double kBoundRounding = 1e-9;

// contact_manifold.cpp

// near_face.cpp, patch_spread.cpp

// Corners of a face nearer than this are one [m]; twice the area of three corners on a line [m^2].
constexpr double kSameCorner = 1e-9, kStraight = 1e-12;
// Of a face with more corners than this those are looked at between which it turns by as much as from corner to
// corner of a regular one with so many, and no others: pairs are too many to compare. Of a round face they leave
// out 0.12 % of its radius at most.
constexpr size_t kFaceCorners = 128;
// Of a shape that is thin as a whole what is higher than this times how far it is aside of another point [-] is
// its far side: 42 degrees, so that corners of a square bar that lies on an edge are, whatever their last bit.
constexpr double kFarSide = 0.9;
// A disc whose rim rises by this share of its radius [-] stands on edge: a wire is seen from its side.
constexpr double kDiscOnEdge = 0.7;
// A face that was cut lost nothing if its area is the same up to this share [-]: rounding.
constexpr double kSameArea = 1e-9;

// triangle_touch.cpp

// What a shape touches is moved off it by the first, or so many times more, up to the last [m].
constexpr double kMovesOff = 1e-5, kMovesOn = 10, kMostMovedOff = 0.1;

// bvh.cpp, bvh_build.cpp

// Overlaps of a shape and a triangle up to this deep count as touching [m]: what was set down exactly
// on a surface. More, and a limb may start that deep in a sheet without being moved out.
constexpr double kMeshTouch = 1e-4;
// Triangles whose doubled area is less have no normal [m^2].
constexpr double kNoTriangle = 1e-14;
// A box, a triangle, may stick out of the plane that culls it by this [m]: neighbours in a flat face
// do, by rounding of normals.
constexpr double kBoxBehind = 1e-9, kTriangleBehind = 1e-7;
// Planes of one shape against one mesh. From the first number on the search ends where all triangles
// within kEnoughReach [m] are settled, at the second one it ends anyway; what is missing is farther than
// the last plane, and the shape may move no farther than that in one step. Fewer: steps near meshes of
// many loose triangles are cut into pieces. More: a search costs their square (2,048: some 20 ms).
constexpr size_t kManyPlanes = 256, kMostPlanes = 2048;
constexpr double kEnoughReach = 5e-3;
// The same for tests of boxes and triangles against planes, some 2 ns each.
constexpr size_t kManyTests = 200000, kMostTests = 2000000;
// What opening a box costs in such tests, measuring a triangle or a hull, and looking for a touch.
constexpr size_t kBoxTests = 4, kMeasureTests = 150, kTouchTests = 750;
// Planes that cull others without being a result. Each is tested against every box and triangle: many
// cost more than they save. No result depends on it.
constexpr size_t kMostCullers = 12;
// Triangles in a leaf, and bins of the surface-area heuristic. No result depends on them.
constexpr int kBvhLeaf = 4, kSahBins = 16;
// Nodes deeper than this are halved by count: deeper than any sensible tree, so that no arrangement of
// triangles makes the depth more than this and the logarithm of their number.
constexpr int kSahDepth = 64;
// Deeper than any tree: those levels, then halves.
constexpr int kMostDeep = kSahDepth + 64;

// triangle_tree.h

// Triangles in a leaf. No result depends on it.
constexpr int kPointLeaf = 4;
// Clusters that are opened at most for one question about a whole ball, and for each of its points. No
// result depends on them: what is not answered is asked point by point.
constexpr int kMostOpened = 2048, kOpenedEach = 8;
// So few points are asked one by one; more are cut in so many parts where a ball has no one answer.
constexpr int kFewPoints = 4, kPointParts = 4;

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

// Used by several phases

// Distances are decided by comparison up to this [m]: a thousand times the rounding of coordinates
// of some metres.
constexpr double kRounding = 1e-9;
// Overlaps up to this at the start are contacts at rest [m]: what scenes and motions lose when they are
// written with five decimals. Less, and things that were set down on each other are pushed apart; more,
// and real overlaps stay.
constexpr double kRestingOverlap = 1e-5;

// People who start overlapping: directions that are tried for the one who is displaced, steps of that and
// the farthest [m]. A person who comes less than this share of the way asked, kStuckPatience substeps long,
// is held back: then the other one is displaced.
constexpr int kPartingWays = 16;
constexpr double kPartingStride = 5e-3, kFarthestParting = 3, kPartingBlocked = 0.25;
// The gap down to which the clearance of contacts gives way where demands cannot all be met [m].
constexpr double kLeastGap = 1e-4;
// Two normals this near (cosine) belong to the same sides of two shapes.
constexpr double kSameSide = 0.5;
// Substeps without progress on the way out of an overlap before another direction is tried: 0.1 s at
// 240 Hz. Less, and directions change while a body is still being turned out of the way.
constexpr int kStuckPatience = 24;

// Poses of skin hulls

// Rates at which a joint moves a vertex by pose blend shapes that are left out of its Jacobian [m/rad].
constexpr double kNoBlendRate = 1e-9;
// A blend of joint rotations whose determinant is less is not inverted (1: a rotation; 0: two joints that
// twist a vertex against each other by half a turn): the point then moves with the hull's first body.
constexpr double kSingularBlend = 0.1;

// Frame sweep

// Parts of a path that is looked at closer, where both ends alone do not prove it clear of a static: feet of a
// walk pass 3 mm over the ground, and a swinging leg is known to stray by up to 10 mm from the straight line of a
// frame at 30 frames/s, by 0.6 mm from that of a quarter.
constexpr int kPathParts = 4;

// Broad phase

// Pairs are listed, and measured by the frame sweep, this much farther than is asked for [m]. Less, and
// the list is made anew more often; more, and it is longer. No result depends on it.
constexpr double kListMargin = 0.1;
// The same of two shapes of one person, which are always near [m].
constexpr double kSelfMargin = 0.15;
// Where nothing of a mesh is near, its distance is looked for this far beyond [m]; no result depends on it.
constexpr double kFartherLook = 1;

// Narrow phase

// Pairs are measured this much farther than is asked for, so that the bound lasts [m].
constexpr double kLookAhead = 0.02;
// Pairs that are farther apart than the clearance by this, as bounds have it, have their plane sought when a
// step takes them near each other [m]: of what touches, and of what is about to, it is sought at once.
constexpr double kWaitingGap = 1e-3;
// Speed at which a clearance that was lost comes back [m/s]: 1 mm in 20 ms. Objects
// that were pressed keep that speed when the body lets go: faster, and they fly off.
constexpr double kRegainSpeed = 0.05;
// A pair of one person that overlaps may get deeper by this share of the depenetration speed, where
// others come out: limbs turn about joints that they share.
constexpr double kDeeperShare = 0.3;
// Other overlaps get no deeper than by this in a substep [m].
constexpr double kOverlapRounding = 1e-7;
// A step that would end nearer than half of kLeastGap (or of the distance it starts from) is shortened;
// under the first of these it may only wear the gap away as slowly as solving is exact, under the
// second not at all [m]. The first is also the least clearance that Python gives the core: the solver
// is exact to about 1e-6 m, and with less a part would sometimes be inside a mesh, which does not hold
// it from there on.
constexpr double kWearFloor = 2e-5, kLastFloor = 5e-6;

// Verification

// Corners of the polygon that stands for a disc: it sticks out of the rim by 0.5 % of its radius.
constexpr int kRimSides = 32;

// End check (end_check.h): overlaps up to the first of these are rounding of what is set down exactly;
// deeper ones are breaches, and those that were deeper before if they grow by more than the second, the noise of
// measuring [m]. At 2e-7, in steps that were shortened again and again, overlaps grew to 7e-6.
constexpr double kBreach = 9e-7, kDeeper = 1e-9;
// Distances from triangles and shapes are looked for up to this [m]; no result depends on it.
constexpr double kEndLook = 5e-3;

// Contact points

// Points of one plane or pair; and those that a pass adds against a static.
constexpr int kMostPoints = 16, kPointsPerPass = 4;
// From this pass on a contact keeps the normal of the start; before, it takes that of the end. With a
// normal that turns on, a corner on an edge may never settle.
constexpr int kTurningPasses = 3;
// A corner this much farther than the nearest point does for it [m].
constexpr double kFlat = 1e-6;
// Points nearer than 2 mm are one contact [m^2].
constexpr double kSamePoint2 = 2e-3 * 2e-3;
// The first points are at least 5 mm apart, where there is a choice [m^2].
constexpr double kSpread2 = 5e-3 * 5e-3;
// A point without an impulse stays for the next substep while its gap exceeds the target by less [m].
constexpr double kStaysNear = 2e-4;
// Points of a face are within this of its nearest one, along the normal [m].
constexpr double kFaceThickness = 2e-3;
// A point is over a static whose surface is this much farther than the candidate's plane [m]: more than
// rounding, less than a corner that sticks out needs to tip.
constexpr double kOver = 1e-5;
// A corner of a mesh counts if it lies so many times farther out than its gap is larger [-]. Less, and
// the sides under a table's edge count; more, and what is slanted rests on its nearest corner alone.
constexpr double kFartherThanDeeper = 10;
// Directions around a disc that lies flat in which it may stick out.
constexpr int kRimLooks = 8;
// Cosines of the normals of one contact in two passes, and in two substeps.
constexpr double kSamePassNormal = 0.9999, kCachedNormal = 0.99;
// Directions of the deepest point of a disc: up to the first difference [-] it is one contact, which is
// turned; up to the second it is left as it is.
constexpr double kSameRim = 0.5, kSettledRim = 1e-4;
// A disc lies on its edge where the cosine between its axis and a tangent of the plane exceeds this.
constexpr double kOnEdge = 0.5;
// Points of a pair are one patch where the cosine of their normals exceeds this (friction_places.h): 8 degrees,
// what a face turns at most between two substeps.
constexpr double kOnePatch = 0.99;
// Points of two pairs are one point up to this distance [m]: a vertex that pieces share, and rounding.
constexpr double kOnePlace = 1e-6;

// Clearances

// A mesh is asked for distances up to this at least: 0 would ask for nothing [m].
constexpr double kLeastRange = 1e-9;

// Posing a shape that is not skin, as a share of posing one that is (step_budget.h).
constexpr double kRigidPose = 0.1;

// Self-contact

// Directions of the lattice, some 15 degrees apart, and steps of the refinement; by how much the best
// direction is turned at first, and at last [rad].
constexpr int kLatticeDirections = 192, kRefinements = 40;
// What a direction costs, most of which are hopeless at once, and what a look at a pair's end pose costs besides, in
// tests (geometry/bvh.h).
constexpr size_t kDirectionTests = 3, kLookTests = 120;
constexpr double kFirstTurn = 0.15, kLastTurn = 1e-4;
// Directions are chosen anew where kStuckPatience substeps leave more than this share of the depth.
constexpr double kEnoughProgress = 0.9;

// Depenetration: the way out of what a motion starts inside of

// Displaced hulls start this far outside [m]: room for kLeastGap and for what solving is off by.
constexpr double kExitClearance = 2e-4;
// Displacements are tried in these strides [m], up to this [m], and the last stride is halved so often:
// to 0.04 mm. A gap that is narrower than a stride may be missed.
constexpr double kExitStride = 5e-3, kFarthestExit = 0.6;
constexpr int kExitBisections = 7;
// Faces of a mesh within this of the group show directions [m], up to so many directions in all.
constexpr double kExitFaces = 0.02;
constexpr int kMostExitDirections = 80;
// What a search may cost within a frame, in tests of some 2 ns (geometry/bvh.h): some 8 ms. At the reset it
// may take the 30 to 60 ms that a person who is cut in half takes.
constexpr size_t kMostExitTests = 3000000;
// Cosines: directions this near are one; directions this near to one that failed are not tried again.
constexpr double kSameDirection = 0.999, kOtherDirection = 0.7;
// Parts that a static cuts off are on its right side only if they carry more than this share of the mass.
constexpr double kGreaterPart = 0.1;
// Planes are asked for this much farther than is needed [m].
constexpr double kExitLookAhead = 5e-3;
// From this depth on shapes come out more slowly [m], but not slower than this share of the speed: what
// comes out fast overshoots.
constexpr double kEaseDepth = 0.01, kLeastPace = 0.1;
// A pair is stuck in a substep in which it progresses by less than one in this of what is asked.
constexpr double kSlowProgress = 10;

// People whose poses are prescribed

// Objects that they overlap are not thrown faster than so many times the depenetration speed ...
constexpr double kThrownFactor = 3;
// ... and so an object between two groups whose exit directions have a smaller cosine than this is not
// pushed: to leave both at the speed asked it would have to be thrown.
constexpr double kOpposedExits = 2 / (kThrownFactor * kThrownFactor) - 1;

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
// Up to so many contacts of an island with people Newton steps are tried before any sweep: they take left and
// right alike. With 8, rigid parts at a wall end 6e-4 m elsewhere where they are turned, with 16 5e-6 m; what
// is undone costs 2 to 3 %.
constexpr int kEvenContacts = 16;

// Sweeps and steps after which an island with people that aims finer than the tolerance is content with the
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

// The path through smoothed problems, for what sweeps and steps leave over kEnough tolerances
// (coulomb_path.cpp). Measured on 1,941 such solves of people at walls, in hands, in stacks and in
// scenes made to squeeze: all but 333 end under kEnough tolerances, of people at walls all. Most of
// the others are squeezed by bodies on tracks and have no answer.

// One unit of impulse: what stops the largest velocity along the most mobile tangent, times this. With
// 1 a sixth more are left. And the normal impulses that the path starts from, in such units: with 1
// a quarter more are left.
constexpr double kPathUnit = 2, kPathStart = 0.3;
// Length of the first stretch, the shortest that is tried, and the factor after one that failed. A
// stretch that took kPathEasy Newton steps or fewer doubles the next: what runs to infinity gets there
// soon.
constexpr double kPathLength = 1, kPathShortest = 1e-6, kPathShorter = 0.4;
constexpr int kPathEasy = 3;
// Newton steps back onto the path, the least that each must bring it nearer, and the distance from the
// path that does, relative to the smoothing. Wider (1e-2) saves a tenth of the work and leaves 6 % more.
constexpr int kPathCorrections = 6;
constexpr double kPathContraction = 0.5, kPathWidth = 1e-3;
// Newton steps of one path: half of them end within 50, nine of ten within 200.
constexpr int kPathSteps = 400;
// ln of the smoothing at which rounding is all that is left.
constexpr double kPathEnd = -25;
// Impulses over so many units end a path: it runs to infinity, or to an answer that is wedged by stress
// within (10^4 N s were seen). At a wall none has more than 15; with 100 a quarter more are left.
constexpr double kPathFarthest = 1000;
// What a path may cost [multiplications], some 10 ms, and the steps that must fit in for it to be
// begun: up to some 36 contacts.
constexpr double kPathWork = 2e7, kPathUsual = 40;

// Normal impulses alone, friction held, where nothing else ended (contact_problem.cpp).

// Rounds of that, each followed by the friction that the new normal impulses bear. From
// kFrictionRounds on, friction over its limit is dropped instead of reduced, so that the rounds end.
constexpr int kNormalRounds = 12, kFrictionRounds = 4;
// Friction that did not settle and pushes along a slip faster than this is dropped [m/s]: 10 g under a
// tonne left at 408 m/s. Less drops what is merely not quite settled; nothing is dropped where the whole
// residual is less: a hand at a wall, 11 tolerances off, was left 3,235 off by that.
constexpr double kDrivingSlip = 0.01;
// Rounds of that: each drops some, until none is left.
constexpr int kDroppingRounds = 24;

// Changes of the active set in one round, and those that may bring no improvement before blocks of
// changes become single ones, which cannot cycle (Judice and Pires 1994).
constexpr int kPivots = 40, kBlockPivots = 3;

// The share of the tolerance to which they are solved: redundant points then agree among themselves.
constexpr double kNormalGoal = 1e-3;

// A contact leaves the active set if its impulse pulls by more than this share of the largest one.
// Redundant points trade rounding among themselves; at 0 that made them pivot without end.
constexpr double kPull = 1e-5;

// Redundant points share what they carry as if they gave way by this share of their own inverse
// inertia: at 10 N s on a limb 4e-5 m/s, under the tolerance. Without it their pivots are singular.
constexpr double kCompliance = 1e-8;

// Budgets, of an island in one solve. They count multiplications, never the clock.

// Contacts that take part at most, and multiplications. What is not solved by then is reported. A
// person inside a box took minutes a frame without a bound, a soup of triangles 10^10 multiplications
// in one step. At 400 contacts A and its copies take 35 MB. The costliest solve of a limp body at a
// wall takes 7.2e6, of two people who meet 5.5e6; 1e8 take some 20 ms.
// From kManyJoined on those that are violated most join first.
constexpr int kMostJoined = 400, kManyJoined = 100;
constexpr double kSolveWork = 1e8;
// What a number costs that is taken from between others, one of a long product, a contact on its own, one
// that joins, besides its products with the others, and an unknown of a Newton step: measured.
constexpr double kScatteredWork = 4, kProductWork = 0.4, kContactWork = 80, kJoinWork = 2000;
constexpr double kUnknownWork = 500;

// The share of it that sweeps and Newton steps leave to the normal impulses alone.
constexpr double kNormalShare = 0.25;

// Contacts that A has room for at first.
constexpr int kFirstCapacity = 16;

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

// Share of the tolerance that islands with people aim at; what is within the tolerance after kFinePatience
// sweeps and steps will do. What is left of a tolerance depends on where a solve began: at 1 a body that is
// pressed on a wall 1 nm farther along it was 84 um elsewhere within a second, at this 0.6 um, and 0.03 um
// without an end of patience, for some 5 % of all instructions there.
constexpr double kSettleGoal = 1e-2;

// An island in which something on a track squeezes others is given up where a contact needs so many
// times the impulse that gives all that moves the largest velocity asked, or where normal velocities
// miss what is asked of them by so many tolerances: then there is no room, and the track must wait.
constexpr double kCrushing = 50, kUnsolved = 20;

}  // namespace hp::tuning::contact

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::stepping {

// Solve and verify (contact_step.h, verification.h)

// Solves in an attempt before clearances give way, and again after that.
constexpr int kMostPasses = 8;
// Solving stops when so many passes in a row have not halved the worst violation: a path that is
// too long to be straight gets no better by more passes; shorter steps do.
constexpr int kStalePasses = 2;
// Violation beyond which giving up the clearance is of no use [clearances]: it frees one clearance
// and cures small conflicts only.
constexpr double kHopelessMiss = 3;
// Violation of contacts of objects that counts as settled [clearances]: stacks pass on what they
// carry one pair a pass, and settle slowly.
constexpr double kObjectSettling = 0.1;
// A gap may miss its target by this share of it: paths that curve within a substep cost no more
// solves. 2 %.
constexpr double kGapSlack = 0.02;
// The same where one of the two is a kinematic body [of the target], at most: nothing stops it, and
// small misses would add up.
constexpr double kKinematicGapSlack = 0.1;
// Overlapping shapes of one person may miss the separation that is asked by this share of it; more
// than all of it, that is, get deeper by a quarter, once the clearance has given way.
constexpr double kSelfExitSlack = 0.5, kSelfExitSlackRelaxed = 1.25;
// Rounding of distances after a substep, at any tolerance [m]; and the same of bodies that nothing
// moves.
constexpr double kDistanceRounding = 1e-9, kLeastMiss = 1e-13;
// Gaps below kNarrowGap [m], after the clearance gave way, are solved to this share of the
// tolerance: coarser solves wear them away.
constexpr double kNarrowGap = 5e-5, kNarrowTolerance = 0.1;
// What is to have no gap, like things that were set down exactly, is solved finer than the end check
// looks [m]. At 1e-6 it refused steps that were solved: a tonne on light boxes lost 14 ms in the first second, and who
// pushed a box of 20 kg up to 2 ms.
constexpr double kNoGap = collision::kBreach, kNoGapTolerance = 0.5 * collision::kBreach;
// Fastest that bodies, and objects, are pushed apart for the sake of a curved path [m/s]: beyond
// that a shorter step is better, and objects that spin fast would gain energy.
constexpr double kMostCorrectionSpeed = 3, kMostObjectCorrectionSpeed = 0.05;
// Contact points, beyond which idle ones go.
constexpr size_t kMostContactPoints = 250;
// Impacts slower than this do not rebound [m/s]: resting contacts stay at rest. Solves for the
// rebound.
constexpr double kBounceSpeed = 0.2;
constexpr int kMostReboundPasses = 3;
// Impulses that work, by more than this share of what they move, gain energy: above the rounding of
// the solver. Bisections of the share of the rebound that gains none: to 1.6 %.
constexpr double kWorkRounding = 1e-6;
constexpr int kEnergyBisections = 6;

// Reach of candidates (contact_step.h)

// Times that planes are asked for, with ever larger reach.
constexpr int kMostQueries = 4;
// Planes are asked for so many times the expected travel, plus the clearance and this [m].
constexpr double kReachFactor = 1.25, kReachMargin = 0.004;
// Every part of a tree is expected to travel at least this share of its fastest part's way:
// contacts speed up what is slow.
constexpr double kSharedReach = 0.35;
// Bodies that are pulled harder than they move are at first not expected to get farther than this
// [m], or than their present speed takes them by this factor: less asks again often, more lists
// needless candidates.
constexpr double kFirstReach = 0.05, kFirstReachFactor = 2;

// Warm start (contact_cache.h) and touches

// A contact is the same as one of the last substep within 2 cm [m^2] and with this cosine of the
// normals.
constexpr double kWarmRadius2 = 0.02 * 0.02, kWarmNormal = 0.8;
// A patch that turns by more than this in a substep has its friction at its points [rad]: drawn in, rods that spin
// by radians gained energy.
constexpr double kTurnsFar = 0.5;
// Contacts of a pair are reported as one touch where the cosine of their normals is larger.
constexpr double kSameNormal = 0.95;

// Budget (step_budget.h)

// Multiplications of a frame of up to kFrameSubsteps substeps, for each person: 35 to 55 ms on a slow machine. What a
// substep may take of what is left, at least; the share of that with which nothing is tried again; what
// an island may take of what is left in the first attempt at it, in one at a shorter piece, and in a
// solve. An island may take kLeastIslandWork in any attempt, and kLeastSolveWork in any solve: trouble
// elsewhere, which leaves nothing, changes no bit of one that needs less. With half of it for an attempt,
// scenes that need many short steps lost up to 97 % of the time; with a fifth for the first one a wall at
// 10 m/s lost 1 %.
constexpr double kFrameWork = 2.6e8, kSpikeShare = 0.4, kWorkReserve = 0.1;
constexpr double kWholeShare = 0.25, kAttemptShare = 0.1, kSolveShare = 0.25;
constexpr double kLeastIslandWork = 7.5e6, kLeastSolveWork = 5e6;
constexpr int kFrameSubsteps = 8;
// What posing a skin is taken to cost, checking a candidate at the end pose, finding it, and a test of a
// search in a mesh [multiplications, of 0.125 ns]: measured times; a candidate that no shape gets near
// costs kBoundWork.
constexpr double kPoseWork = 8e3, kCheckWork = 3e3, kPlaneWork = 8e3, kTestWork = 25;
constexpr double kBoundWork = 150;
// What a contact costs in a pass, and to be looked at for each violated candidate or new contact.
constexpr double kPointWork = 4e3, kLookWork = 80;
// Violated candidates, for each person, from which on contacts are made of the worst of each shape only,
// kPatchPlanes of them with normals that differ by this cosine: the planes that bound a patch span it, the
// rest of them is violated again in the next pass if that was not enough.
// Of all shapes kMostPatchPlanes, the worst.
constexpr size_t kManyViolated = 120, kMostPatchPlanes = 150;
constexpr int kPatchPlanes = 6;
constexpr double kPatchNormal = 0.95;
// Candidates that may be added to those of an attempt because forgiven planes had hidden them.
constexpr size_t kMostHidden = 500;

// Sub-stepping (sub_stepping.h)

// Pieces that the rest of a step is tried in, at most; what is left then is lost time.
constexpr int kMostPieces = 32;
// A piece of which a smaller share than this is possible is not begun but tried this much shorter.
constexpr double kLeastShare = 0.25, kShorterPiece = 0.125;
// Time left counts above this share of the step.
constexpr double kNoTimeLeft = 1e-6;
// Bisections for the share of a step that is possible: to 1/64.
constexpr int kShareBisections = 6;
// Searches for it: what one did not look at may not be clear at its end.
constexpr int kMostShareRounds = 4;
// A shape that moves farther than its planes were asked for keeps this much of what lies beyond
// [m].
constexpr double kBeyondReach = 1e-4;

// The frame (free_paths.h, substep.h)

// Bodies that are stepped through may stray this far from what they would do by themselves before
// people on free paths are looked at again [m].
constexpr double kFrameStray = 0.03;
// An object or link that turns farther than this in a substep makes it in parts, so that it turns
// less than a quarter of it in each, up to so many parts [rad]. Larger turns let contacts add
// energy.
constexpr double kMostTurn = 1.0;
constexpr int kMostTurnParts = 32;

// Drive (drive.h)

constexpr double kRootRecoveryTime = 0.3;  // time constant of the root's way back to its path [s]
// The same of the height of somebody with weight [s], and the fastest fall that is asked for [m/s]: its
// force is its weight, so that gravity has its pace where strength is limited.
constexpr double kFallTime = 0.1, kFallSpeed = 3.0;
// Algorithm 1 turns a joint back by `recovery_rate` and so many times the speed that the motion has
// itself. T-pose at a wall, lambda 1: 400 to 600 frames/s beside no bound. A kick at 12 m/s into a
// fixed ball bends the knee by 36 degrees without a bound, by 36, 34, 30 with 3, 2, 1 times.
constexpr double kReturnPerMotion = 3;
// Time constant with which limp joints of Algorithm 1 are damped against the velocity that their frame
// set [s]. T-pose at a wall: the fastest vertex moves at 7 m/s undamped, 0.2 at 0.14 and at 0.07 s; the
// knee of that kick bends by 36, 28, 26 degrees: less is not limp.
constexpr double kLimpTime = 0.14;
// A body counts as touched for this long after a contact [s]: contacts come and go.
constexpr double kTouchedTime = 0.1;
// Deviations from the motion below these are what a contact leaves in rounding [rad], [m/s, rad/s].
// Larger ones drop motion, smaller ones step people through without need.
constexpr double kSettledAngle = 1e-11, kSettledSpeed = 1e-9;
// In so many implicit steps it is looked ahead how the root will turn back in a frame: as by default.
constexpr int kFrameParts = 8;
// A deviation whose square is smaller is rounding: free motion must not cost a factor [rad^2].
constexpr double kLeastDeviation2 = 1e-26;

// Strength and held loads (strength.h, held_load.h)

// Share of its strength that a joint pulls with by itself: the rest is for what holds the body to
// move.
constexpr double kPullShare = 0.97;
// Joints that exceed their strength are to exert this share of it in the next round; rounds of
// that, after which the pull alone is left.
constexpr double kResistShare = 0.9;
constexpr int kResistRounds = 6;
// Changes of velocity [m/s, rad/s], and impulses [N s, N m s], below these are rounding.
constexpr double kVelocityRounding = 1e-9, kImpulseRounding = 1e-9;
// Joints that give way under a load: they turn no more slowly than this where another one gives way
// [rad/s]; their torque meets the limit to this share, within so many rounds; over-relaxation of
// the logarithms of rates; resistance of joints without a limit [kg m^2].
constexpr double kLeastYieldRate = 1e-3, kYieldTolerance = 0.02;
constexpr int kYieldRounds = 60;
constexpr double kYieldOverRelaxation = 1.5, kRigidResistance = 1e10;
// What stands on a movable thing within so much of one point [m] does not hold it from turning; a thing that
// would pass under it by less than this [m/s] need not be solved for: 0.01 mm in a second. Points that carry less
// than this of a person's weight hold nothing: far from where it presses shares go down to 1e-300.
constexpr double kStandingPoint = 1e-3, kStandingSlip = 1e-5, kStandingShare = 1e-6;
// Friction of who stands is whole where its nearest point is up to the first gap above the thing, and none from the
// second on [m]: who sat down drew a chair on wheels by 6 mm before touching it.
constexpr double kHolds = 0.003, kHoldsNot = 0.01;
// No object leaves contacts faster than this many times the fastest point of all else in its island, or than
// so much [m/s]: a gram under a sliding tonne left at 49 m/s (squeezed.h).
constexpr double kSqueezeFactor = 10, kLeastSqueezeSpeed = 2;
// Rounds after those, in which joints only give way more, until none exerts more than its limit: three
// substeps of a person who flails at a wall had not ended by then, and exceeded it by up to 0.4 %.
constexpr int kSafeYieldRounds = 60;

// Contacts within a person, joints that nothing touches (self_response.h, untouched_joints.h)

// Bodies that carry more of a person's mass than this share are trunk, which follows the motion.
constexpr double kLimbMass = 0.25;
// Of two limbs the lighter one gives way alone where the other has so many times its mass.
constexpr double kLighterLimb = 2;
// Bodies that carry less of a person's mass than this share (fingers) resist as if they had this
// much inertia more while an overlap separates [kg m^2]: they would be flung.
constexpr double kFingerMass = 0.003, kFingerResistance = 0.05;
// Demands that limbs alone miss by this cannot be met by them [m]: more joints take part.
constexpr double kSelfContactMiss = 1e-5;
// Joints beyond which nothing touches have so many times the added inertia: with much less, jaw and
// feet of a body that runs into a wall swing.
constexpr double kUntouchedResistance = 100;

// Ranges of people's joints (joint_ranges.h)

// What a row counts an angle with [m/rad]: as the way of a hand's or foot's end, so that it is solved to the
// contacts' tolerance, which is then 1e-5 rad.
constexpr double kRangeLever = 0.1;
// An angle that misses its end by more than this [rad] has a row where its island is solved; by more than
// kRangeSlack, 0.1 degrees, it has its island solved. Passes in which angles are looked
// at: what is left then, the next substep takes back.
constexpr double kRangeRounding = 1e-9, kRangeSlack = 0.002;
constexpr int kRangePasses = 5;
// A joint that is beyond an end already is taken back at this speed [rad/s]; the drive adds its own.
constexpr double kRangeReturn = 3;
// Joints that end farther than this beyond [rad] make a step shorter: 1 degree.
constexpr double kRangeMiss = 0.0175;
// Where an island does not settle, rows let a joint go this far beyond in the substep [rad], attempt by
// attempt; after the last one there are none.
constexpr double kRangeGive[] = {0, 0, 0.02, 0.02, 0.1, 0.1};
constexpr int kRangeLevels = 6;
// Fastest that a joint is turned for the sake of a curved way [rad/s]: beyond that a shorter step is better.
constexpr double kMostRangeCorrection = 5;

// Depenetration (exit_motion.h)

// No point of a body that comes out of an overlap is faster than the motion by this [m/s].
constexpr double kExitSpeed = 0.85;
// A step that is faster, or not possible, is tried with less exit speed: by 0.9 of what is needed,
// or to this share, and to this least share in one try, so often; then with none. It grows by
// kExitGain a substep.
constexpr double kExitMargin = 0.9, kExitCut = 0.3, kLeastExitCut = 0.1;
constexpr int kExitTries = 4;
constexpr double kExitGain = 1.3;
// Inertia added to joints of a person who comes out, in times their own: on the paths from the root
// to the parts that come out, which then go as a whole, and elsewhere: what pushes a foot must not
// swing an arm.
constexpr double kExitPathInertia = 3, kExitOtherInertia = 300;
// A person who is out goes back to the motion at this speed [m/s], until all joints are this near
// to it [rad], for so long at most [s].
constexpr double kReturnSpeed = 0.7, kReturnAngle = 0.01, kReturnTime = 0.5;
// Joints move points at this distance at least [m]: bounds the angular speed that kReturnSpeed
// makes.
constexpr double kLeastJointReach = 0.02;

// Kinematic and sleeping bodies (kinematic_bodies.h, sleeping.h)

// A kinematic body that crushes goes at this share of its pace in the next try, no slower than the
// second of these (then it stands); it gains pace by kPaceGain a substep; standing, it waits so
// many substeps at most.
constexpr double kPaceCut = 0.25, kLeastBodyPace = 1.0 / 16, kPaceGain = 2;
constexpr int kMostPaceWait = 32;
// Sleeping objects this near to one that wakes wake too [clearances].
constexpr double kWakeRange = 2;

// Another engine's world (hosting.h)

// Coordinates that differ by less from where a substep left them differ by rounding; a body that is
// farther off has been placed there [m, rad].
constexpr double kPlacedByHost = 1e-12;

// Baselines (baselines/)

// Internal forces grow with the square of velocities, and limp limbs would run away with what they
// gain: they turn no joint faster than this, or than it was [rad/s]. Bullet has the same limit.
constexpr double kFastestInternalSpin = 100;
// Prescribed poses: no push makes an object faster than collision::kThrownFactor times the speed
// asked, or than it was and that speed at right angles, with this margin.
constexpr double kThrownAcross = 1.01;
// Such a push is tried again more gently: with kPushMargin of what is needed, no less than
// kLeastPush of it, or kNoRoomPush where the object has no room; so often. It gains by kPushGain a
// substep.
constexpr double kPushMargin = 0.9, kLeastPush = 0.1, kNoRoomPush = 0.3, kPushGain = 2;
constexpr int kPushTries = 3;
// An object without room is not pushed for this long at first, then up to the second [s].
constexpr double kLeastPushWait = 1.0 / 120, kMostPushWait = 0.25;

}  // namespace hp::tuning::stepping

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::support {

// A Newton step ends where the slope of the dual along it is at most this part of that at its start.
// With a tenth more is searched than steps are saved; near 1 places that join halve the speed.
constexpr double kSpreadFlat = 0.5;
// Part of the wrench under which the gradient counts as 0 at penalties that are only on the way: at
// 0.01 problems that cannot be met take 10 steps in the mean and 30 at most, at 1e-4 a seventh more;
// without the way there 1 in 80 was not solved in 40 steps.
constexpr double kSpreadCoarse = 0.01;

}  // namespace hp::tuning::support

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::footing {

// surface_below.cpp

// Surfaces whose unit normal has less of the vertical are walls, nothing to stand on: steeper than 60
// degrees, beyond any shoe's friction.
constexpr double kSteep = 0.5;
// Objects count as ground only up to this far above a sole [m]: what is higher is being kicked.
constexpr double kOnObject = 0.02;
// A fall towards a convex shape begins this far above its box [m], has landed this near [m], and takes
// at most so many steps: one for a face, some ten for round sides.
constexpr double kAboveBox = 1e-3, kLanded = 1e-7;
constexpr int kFallSteps = 48;

// What is more than this above a sole [m] is stepped on only where it goes on, at the same level to the second [m],
// in at least kAroundFound of kAround directions at the distance of half a foot's width [m]: along a bar it does in two,
// at the corner of a stair in three.
constexpr double kStepsOver = 0.03, kSameLevel = 0.03, kFootWidth = 0.08;
constexpr int kAround = 8, kAroundFound = 3;
// Of what is too narrow so many are looked past, from this far under each [m].
constexpr int kNarrowThings = 4;
constexpr double kUnderIt = 1e-3;

// leg.cpp

// A leg reaches this share of the length of its bones: stretched to the end its knee would turn at any
// speed (at 0.9995 by 5 degrees in a frame, for 2 mm). Legs that the motion has straighter stay so.
constexpr double kLegReach = 0.997;
// Angles of a leg's joints may miss their ranges by this [rad]: rounding. So often is the share of a shift
// halved that hip and knee can make: to 0.1 mm of 25 cm.
constexpr double kLegRangeMiss = 1e-9;
constexpr int kLegBisections = 12;
// So often at most a knee is bent anew that would turn aside beyond its range: 0.01 of that is left each time, unless it is
// bent as far as it goes.
constexpr int kKneeTries = 8;

// flight.cpp

// Who gains so much of g downwards flies; the speed that it is measured against has this time constant [s]. At 30
// frames/s positions that are off by 1 mm gain 0.1 g, at 120 0.35 g; the bobbing of a walk is 0.3 g.
constexpr double kFlies = 0.5, kFlightTime = 0.05;

// footing.cpp

// A foot that is less than this under the ground half-way between two targets is left there, and one that
// is more is lifted at the end by twice that, and no more than the second [m].
constexpr double kSags = 1e-4, kMostSag = 0.03;
// How far above its own height static geometry is a step for a sole [m], a stair and a half; and for
// skin, which does not step; how far below a point a surface is looked for [m].
constexpr double kStepUp = 0.25, kPressedIn = 0.06, kDeep = 3.0;
// No step is higher above the person's lowest point than the first [m]: heels of a foot that swings, on the height that
// a step has given, climbed on from a step to a seat. A foot that goes on resting takes up the second at most, a
// low stair over whose edge it creeps: people who were pushed over the rung of a chair rose by 0.3 m in a squat.
constexpr double kStepFrom = 0.3, kCreepsUp = 0.12;
// Soles stand this far beyond the clearance [m], so that standing is no contact: some bulges of a hull
// between its points, and sags on its way between two frames. With 0.2 mm a recorded walk touches the floor
// in 21 of 152 frames, with 1 mm in 8, with 2 in none, and a frame that touches costs as much as fifty.
// Who is nowhere nearer than the second is not lifted.
constexpr double kSoleGap = 2e-3, kLeastSoleGap = 2e-4;
// Feet that move pass over the ground this much higher [m]: a toe that touches it catches, and the foot
// folds under itself (by 140 degrees in a recorded walk whose toes drag 9 mm deep).
constexpr double kSwingGap = 6e-3;
// A foot that swings is looked at so often ahead, at intervals of the second [s], and goes up at this pace, c [s]: of 10
// clips on stairs knees jerk over 1.5 times as much as recorded in 3; with 3 looks and equal parts in 4. Without, toes of two
// of them are bent by 50 degrees at risers.
constexpr int kLooks = 8;
constexpr double kLookTime = 0.025, kLookPace = 1.0 / 30;
// It is looked at again where it has gone so much farther, and no farther away than the second [m]: a jump of the motion
// is no way.
constexpr double kLookWay = 0.02, kLookFar = 0.7;
// What floats by less than this is left as it is [m]: recorded feet do.
constexpr double kFloats = 1.5e-3;
// A point of the reference rests where it is slower than the first, moves where it is faster than the
// second [m/s]: a stance foot of recorded walks drifts by 0.1, swings at 1 to 4. It is low up to the
// first height above the person's lowest point, high from the second [m].
constexpr double kRests = 0.15, kMoves = 0.35, kLow = 0.02, kHigh = 0.05;
// A body that goes beside its motion by less than this in a frame does not [m]: rounding.
constexpr double kNoWay = 1e-9;
// A foot that rests by more than this share rests.
constexpr double kAtRestShare = 0.5;
// Who is tilted so that cos of half of it is less than this has no heading.
constexpr double kUpsideDown = 0.3;
// A step ends on ground that is at most so much higher or lower [m].
constexpr double kLandsUp = 0.12, kLandsDown = 0.15;
// Feet of who sits are on the ground in a motion that has them this low over it [m], and are not from the second
// on.
constexpr double kOnFloor = 0.01, kOffFloor = 0.05;
// What is farther than this above any surface [m] carries only after it has rested so long [s]: at the
// top of a jump a foot rests for 0.05 s.
constexpr double kFar = 0.06, kRestTime = 0.1;
// Feet of somebody who sits or lies hang where they are farther than this from the ground [m]: they do not
// reach for it.
constexpr double kHangs = 0.15;
// Who is at most this far above a surface is on it [m]; who is held by contacts farther than the second above where
// it was put has been lifted onto something.
constexpr double kOnGround = 0.02, kRaised = 0.1;
// A contact holds a person up if so much of its impulse points up; contacts carry a person if those that do
// bear this share of its weight. With any share a thumb on a couch held people in the air.
constexpr double kHeldUp = 0.5, kCarriedShare = 0.5;
// What a standing person can push with, in its own weight: m g d / h, d some 0.3 m of a stride from the
// centre of mass to the edge of the support, h some 0.9 m. Measured pushes of upright walkers are 150 to
// 300 N.
constexpr double kPush = 0.4;
// How fast feet speed a body up along the ground [m/s^2]: kPush of its weight.
constexpr double kFeetGive = kPush * 9.81;
// Firmness of the toes of somebody with a footing: at 1 they curl by 98 degrees under a foot that is 1 cm in
// the floor, at 300 by 5; it is that of an inertia of 20 g.
constexpr double kToeFirmness = 300;
// Toes have it while their foot rests, more or less, no higher than this over the ground [m]: with it in the
// air, or as it brushes the ground, a foot kicks a ball of 0.5 kg away at 6.8 m/s at 30 frames/s and 6.2 at
// 120, without at 6.0 and 6.2.
constexpr double kBears = 0.015;
// What is exerted in the air [N]: nothing, but limits are over 0.
constexpr double kInTheAir = 1e-3;
// Skin carries where it is nearer than this to a surface under it [m] and faces it, by the vertical
// part of its unit normal.
constexpr double kCarries = 0.03, kFaces = 0.5;
// Frequency of the critically damped height [rad/s]: a step of 10 cm is taken in half a second. It
// falls with gravity and rises with so much of it. Somebody whose leg does not reach the ground that it is to stand on,
// who steps aside or is pushed, comes down faster [rad/s]: of 52 runs in rooms 22 had fewer frames without support and 3
// more; at 20 they have no fewer, and at 25 one more of 60 displaced clips has knees that jerk.
constexpr double kHeightRate = 8, kRise = 2, kHangingRate = 12;
// In a frame it turns by so much at most [rad]: from 0.83 on it would ring.
constexpr double kHeightShare = 0.5;
// Less time than this tells no speed [s].
constexpr double kNoTime = 1e-6;
// The height has come to rest when it is this near [m] and slow [m/s].
constexpr double kAtHeight = 1e-6, kAtRest = 1e-5;
// How fast a sole is corrected up [m/s], and the rate of its critically damped way down [rad/s]: at 1 m/s, without
// one, knees jerk twice as much as those of recorded clips (1.5 times at most in 11 of 60), with a time constant of
// 0.05 s in 29, with the rate in 41, and with kLegReach too in 51; at 20 rad/s dancing feet hang 3 mm more.
constexpr double kLift = 2.0, kLowerRate = 25;
// How fast a foot goes up that rests and has crept over an edge [m/s]: at kLift knees jerk by 30,000 rad/s^3.
constexpr double kLiftAtRest = 0.5;
// A lifted sole is not taken up by a person who rises faster than the first [m/s], beyond the second over where it is to
// be [m]: it hung 30 mm over the ground as a dance came down from 15 cm. Without the first, knees jerk more (1.5 times
// at most in 47 of 60 clips), with neither in 46.
constexpr double kRisesSlowly = 0.05, kHangsBehind = 4e-3;
// A person may start this much higher or lower than asked to stand [m]: what recordings are off by.
constexpr double kStartShift = 0.1;
// It starts as asked if it would otherwise be deeper in something by this [m].
constexpr double kDeeperAtStart = 1e-6;
// What is no farther than this in static geometry is over it, and does not sink into it as the person
// comes down [m].
constexpr double kNotSunk = 0.01;
// Hands over things keep nobody up who is farther than this above what it is to stand on [m]: it falls.
constexpr double kFallsPastHands = 0.05;

// footwork.cpp

// A foot is left behind by no more than this [m], and turned by this [rad]: then it slides. Legs reach 0.3 m, ankles
// turn by 0.35.
constexpr double kMostBehind = 0.25, kMostTurned = 0.35;
// One that was put down to wait may be this far from under its hip [m]: half a long stride.
constexpr double kMostStride = 0.45;
// A foot at rest that is farther than this from where it is to be has been stopped, and stays there [m].
constexpr double kStopped = 0.02;
// How fast it then comes down, or up, and level [m/s, rad/s], at least; and the rate [1/s]: legs that were 0.8 m up
// when their person came off a chair hung in the air for 1.4 s.
constexpr double kSettles = 0.5, kSettlesTurn = 2, kSettlesRate = 8;
// How fast a foot in the air gives up what it was held back by [m/s], and how far it was turned [rad/s].
constexpr double kGiveUp = 1.5, kGiveUpTurn = 3;
// Who moves steps from these on [m, rad]; who has come to rest puts the feet where they belong to these.
constexpr double kStepAt = 0.08, kStepTurn = 0.25, kTidyAt = 0.03, kTidyTurn = 0.1;
constexpr double kTidySpeed = 0.03, kTidySpin = 0.05;  // of who moves [m/s, rad/s]
// Two feet that differ by less than this are as late as each other: a share of what lets one step. More than
// what a second of contact leaves of rounding, less than anybody sees.
constexpr double kAlikeLate = 1e-3;
// How long both feet have stood before one of them is lifted [s]: the two of a walk stand together for 0.1 s.
// Who waits lifts one as soon as it stands.
constexpr double kStood = 0.2, kStoodToWait = 0.05;
// A foot hangs behind that has rested for so long in the motion [s], at this share of how far it may be from its home.
constexpr double kHangsFor = 0.5, kHangsAt = 0.95;
// A foot that is less than this above its ground stands [m].
constexpr double kStands = 0.01;
// A step lasts the first [s], less kHurry for every m/s that the body goes beside its motion, but no less than the
// second. It is so high [m].
constexpr double kStepTime = 0.4, kQuickestStep = 0.2, kHurry = 0.2, kStepHeight = 0.04;
// For this share of a step it follows the body that moves on; then it is known where it ends.
constexpr double kAims = 0.6;
// A foot stands for this long between its steps [s], and is put at most so far ahead of the body [m].
constexpr double kStance = 0.5, kMostAhead = 0.15;
// Time constant of the speed of a body beside its motion [s]; less than the second is none [m/s, rad/s].
constexpr double kSlideTime = 0.15, kNoSlide = 1e-3;
// If there is no ground where a step would end it is shortened, by this share at a time.
constexpr double kShorter = 0.25;
// A foot whose other one is lifted by the motion comes down so much faster.
constexpr double kInTheAirToo = 2;
// A body goes slower over the last of what its feet can be left behind [m], but at this share of its pace.
constexpr double kSlowsDown = 0.1, kSlowestPace = 0.15;

// way_round.cpp

// Who is farther than this off the path [m], and is touched, looks for a way round.
constexpr double kOffPath = 0.5;
// Who goes round something goes so much faster than the motion does.
constexpr double kCatchesUp = 1.25;
// The middle of a body is a vertical capsule of this radius up to this height [m]; it needs so much room around it,
// a body's half width with the arms at its sides, and has enough with the last.
constexpr double kMiddle = 0.08, kChest = 1.4, kBodyRoom = 0.14, kRoomy = 0.3;
// A place without any room costs so much more than one with enough.
constexpr double kNarrow = 4;
// Size of a cell and how many there are to each side of the middle: 4 m. So many are looked at, at most.
constexpr double kCell = 0.15;
constexpr int kHalfGrid = 27, kMostCells = 1500;
// Who is this near to where it started may be as near to things as there [m]; less than the second is rounding.
constexpr double kLeaves = 0.35, kSameRoom = 1e-9;
// Straight ways are looked at in steps of this [m]. A point of the way that is this near has been reached [m].
constexpr double kLook = 0.1, kReached = 0.15;
// Who is farther away [m] goes straight on: no map reaches there, and all of the line would be looked at.
constexpr double kFarthest = 100;
// A way is found anew after so long [s], or when its end has moved by so much [m].
constexpr double kFindsAnew = 0.5, kMovedOn = 0.3;

// bearing.cpp

// A point of a person carries it up to the first height above a surface, not at all from the second on [m]:
// soles are curved, and follow what sinks under them with a delay.
constexpr double kPresses = 0.02, kPressesNot = 0.05;
// Time constant of what a point presses with [s]: a foot that sets down has taken over 95 % after 60 ms. Less
// than the last of a person's weight is nothing.
constexpr double kLoadTime = 0.02, kNoLoad = 1e-4;
// Time constant of what contacts press with [s]: longer than they rattle.
constexpr double kPressedTime = 0.1;
// e of the centre of pressure [m^2]: 0.3 mm for a centre of mass over the edge of the balls of the feet.
constexpr double kPressureSlack = 1e-5;
// The centre of pressure is found to this [m], in at most so many steps of Newton's method; a step gains this
// share of what its slope promises, and is no shorter than the last.
constexpr double kPressureMiss = 1e-9;
constexpr int kPressureSteps = 40;
constexpr double kPressureGain = 1e-4, kLeastPressureStep = 1e-6;

// wading.cpp

// Legs of a person whose layers are pressed to the frame are folded where it is lower than the frame lets it by more
// than this, wholly from the second on [m]. Dances and hops of 0.3 m on a mattress of 18 cm end 0.7 to 1.3 m
// too low without, as every landing folds the legs a little more; who stands is within 1 cm.
constexpr double kUnfolded = 0.02, kFolded = 0.1;

// Shares of feet are those about the point where the centre of mass will be after this [s], the time constant of an
// inverted pendulum of a body's height being 0.3 s, and follow at this rate [1/s]: the other foot of a walk leaves 0.15 s
// after one has come down. At 20 walks over mats of 2 to 20 cm press with up to 2.0 times the weight, at 12 with 1.8.
constexpr double kWadeAhead = 0.25, kWadeRate = 12;
// Time constant of walking, of who stands on layers [s]: longer than the double support of a walk, 0.1 s.
constexpr double kWadeTime = 0.3;
// A leg that carries gives way by what the person rises in this time, and stretches as it falls [s]: it damps the
// bounce, 0.4 of the critical at 14 rad/s.
constexpr double kWadeGives = 0.06;
// Rate of the way down of a foot on layers, whose share is smooth already [rad/s].
constexpr double kWadeLower = 80;

// underfoot.cpp, on_layers.cpp, stepping/layer_load.cpp

// A part that is put on a soft layer goes so far below its surface [m], by no more than this share of its thickness:
// contacts carry it from there on.
constexpr double kDips = 5e-3, kDipsShare = 0.25;
// Layers carry a person from this share of its weight on: what is less is nothing.
constexpr double kCarryFrom = 1e-4;
// Who stands on hard ground and presses on layers with less than this share of the weight is not carried by them: a
// hand on a cushion, a pillow between two palms.
constexpr double kBrushes = 0.03;
// Time constants of the share of the weight that layers are to carry, and of the centre of their pressure [s]:
// shorter than people sit down in, longer than steps of contact.
constexpr double kLayerShareTime = 0.05, kLayerCentreTime = 0.05;
// Share of the weight that layers have at least under somebody who sits on them, where the moments leave a choice; and
// in any case.
constexpr double kSeatShare = 0.5, kLeastLayerShare = 0.01;
// Firmness of the joints of the legs of somebody whom layers carry, who bears the weight on them: at 1 ankles on a
// mattress give way by 30 degrees, at 30 by 2.
constexpr double kLegFirmness = 30;
// Somebody on layers rests whose root moves slower than this, and moves from the other speed on [m/s]; a turn counts at
// this distance [m]. How fast that comes to be [s].
constexpr double kRestsOnLayers = 0.05, kMovesOnLayers = 0.15, kTurnArm = 0.3, kComesToRest = 0.2;
// Rate of the spring that turns the root of somebody who rests on layers back to the motion [rad/s]. Lying, nothing
// supplies it: some 40 N m/rad, where a mattress has 14,000; at 5 the centre of pressure stays 2 cm off. Seated, feet on
// the ground do: at 11 a person on a sofa leaves 86 % of the weight on seat and rest, at 5 79 %; people 69 to 81.
constexpr double kLyingRate = 2, kSeatedRate = 5;
// Who has no feet on the ground turns freely if no more of the pelvis' axis than the first of these is vertical; from the
// second on it sits, and does so only where it leans by no more than the third, and not at all from the last on [rad].
constexpr double kLiesFlat = 0.5, kSitsUp = 0.7, kLeansFreely = 0.25, kLeansHeld = 0.5;
// Whose feet are nearer than the first of these to below its centre of mass, along the ground, squats over them; from the
// second on it sits behind them [m].
constexpr double kSquats = 0.2, kSitsBehind = 0.3;
// Feet are no nearer to below the centre of mass than this, as levers [m], and carry no more of the weight of who sits.
constexpr double kShortestLever = 0.1, kMostOnFeet = 0.5;
// Rate at which a person who rests on layers loses velocity off its motion, up or down [1/s]: what muscles and flesh
// damp, some 0.3 of the critical on a mattress. At 100, as the drive has it, sinking takes seconds.
constexpr double kLayerDamping = 10;

// stepping/reference_clock.cpp

// The clock of a person slows down from the first distance behind its path on and stops at the second
// [m]: a few centimetres are what bodies give, and recovery takes back.
constexpr double kBehind = 0.04, kBlocked = 0.12;
// A reference slower than this goes nowhere [m/s].
constexpr double kStill = 0.1;
// Rate of a clock that is to stop while the motion flies.
constexpr double kSlowest = 0.1;
// How fast the rate of a clock grows [1/s]: who goes on at once meets what it waited at with twice its speed.
constexpr double kSpeedUp = 1.5;
// Who waits and is not touched for this long goes back to where it was blocked [s].
constexpr double kTriesAgain = 1.0;
// Who is blocked comes back to the pose of the motion at this speed [m/s]: at full speed a leg that a wall has
// stopped throws the body back by a metre. At 0.3 a door jamb is pushed with 370 N, at 0.2 with 180 N.
// As a whole it turns back at the last [rad/s]: as slow as joints, it stands askew until it goes on.
constexpr double kYieldSpeed = 0.2, kYieldTurn = 1.0;
// How long somebody waits before going on [s].
constexpr double kPatience = 3.0;
// Who lags by more than the first catches up at this rate where nothing is in the way, and nobody lags by more
// than the second [s]: three waits in a row, and as much again. A pose that waits takes 1.8 kB.
constexpr double kLate = 10.0, kLatest = 20.0, kCatchUp = 1.25;
// Times that differ by less than this share are the same.
constexpr double kSameTime = 1e-9;

}  // namespace hp::tuning::footing

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::soft {

// Patches of one pair: of samples whose layers face the same way, by this cosine (45 degrees) from the one
// that is pressed most. More: more rows to solve; fewer: moments are coarser where a shape wedges.
constexpr int kMostPatches = 3;
constexpr double kSamePatch = 0.7;
// A patch narrower than this about its middle is a line, or a point [m].
constexpr double kPointSpread = 5e-4;
// Nor does a patch of a person turn its part by more than its middle does, where it resists turning by less
// than this [kg m^2]: h^2 times its stiffness. A thigh has 0.1.
constexpr double kFirmTurn = 2e-3;
// Parts of less than this share of a person's mass press static layers together with the part that they hang on:
// fingers, which have up to 0.00024. Not toes, on which people stand: 0.0011; nor hands: 0.0034.
constexpr double kSmallPart = 6e-4;
// Samples are measured this much farther than is asked [m], so that they need not be soon again.
constexpr double kSeenMargin = 0.03;
// Cells that foam remembers in, to the metre: of 2 cm; and the memory that is none [m]. More cells: a dent of
// finer shape, and what slides finds fresh foam more often.
// The grid is shifted by a share of a cell, so that no surface at a round number lies on a border.
constexpr double kFoamCells = 50, kCellShift = 0.3717, kForgotten = 1e-5;
// Objects on layers so stiff that (omega h)^2 is over this are stepped by implicit Euler: a step does not
// show their bounce, and a rule that keeps its energy would ring.
constexpr double kStiffBounce = 1;
// Beyond this sum of tilts a point of the patch would have to pull; 1 is where it carries nothing.
constexpr double kMostTilt = 1;
// A hull is a box whose normals are square to each other within this cosine, and whose vertices are its
// corners within as many metres: more than rounding, less than anybody shapes.
constexpr double kSquare = 1e-9;
// Distances whose direction is rounding alone [m].
constexpr double kNoDistance = 1e-9;
// Depths spread by no less over a sample [m]: means are differences over it.
constexpr double kLeastEdge = 1e-5;
// A change of depth by less has the pressure of its middle [m].
constexpr double kNoIndent = 1e-6;
// How far beyond what is asked a distance is measured, that it need not be soon again [m].
constexpr double kRoomMargin = 0.2;
// Solves of a step in which condensed pressures are looked at again, at most. What is then left is
// accepted: the hard frames are kept all the same.
constexpr int kMostLooks = 5;
// What looking at a sample is taken to cost [multiplications, of 0.125 ns].
constexpr double kSampleWork = 2e3;
// The pressures at the end are those of the solve if the sums of force and moment differ by less than this
// share, or by an impulse that small [N s]: free objects must not gain energy by it. People are driven, and
// their rows are made anew in every step: what is off is gone in the next.
constexpr double kRightShare = 3e-4, kRightShareDriven = 1e-2, kRightImpulse = 1e-7;
// Moments of pressures nearer to the middle than this may differ as if they were so far from it [m].
constexpr double kLeastLever = 1e-3;

}  // namespace hp::tuning::soft

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::labels {

// Distances of a skin's vertices to a thing are known this much farther than the reach that is asked
// for [m], where points of the thing look for faces: a face may be in reach though its corners are
// not. Faces with longer edges than this are looked at one by one; the result does not depend on it.
constexpr double kPointSearchMargin = 0.1;

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
