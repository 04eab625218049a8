// The substep: drive, contact, verification, integration; and the frame made of substeps.
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "dynamics/articulation.h"
#include "collision/narrow_phase.h"
#include "stepping/drive.h"
#include "contact/solver.h"

namespace hp {

// The poses of a thing that nothing pushes: straight lines, and turns at a constant rate, between them.
struct Track {
  int body = 0;
  double fps = 30;
  bool loop = false;  // the first pose follows the last one
  std::vector<Vec3> position;
  std::vector<Quat> turn;

  void at(double time, Vec3& p, Quat& q) const;
};

// What touched in a frame, summed over its substeps.
struct Touch {
  int shape = 0, other_static = -1, other_shape = -1;
  Vec3 position, normal, impulse;
  double weight = 0;
};

struct Diagnostics {  // of one frame
  int candidates = 0, contacts = 0, passes = 0, sweeps = 0, shortened = 0;
  double residual = 0;   // largest gap missing at the end of a substep [m]
  double lost_time = 0;  // [s]
};

// How the motion gets into the world: by velocity, or as a pose that is set (forced.cpp) once a frame with nothing
// touched, or once a frame, or in every substep, with things pushed out.
enum class Forced { No = 0, Kinematic = 1, Positions = 2, Interpolated = 3 };

// Who came out of something goes back to the motion no faster than this [m/s].
constexpr double kGentle = 0.7;

class Stepper {
 public:
  Stepper() = default;
  Stepper(const Stepper&) = delete;
  Model model;
  World world;
  Articulations articulations;
  DriveSettings drive_settings;
  Vec3 gravity{0, 0, -9.81};
  double clearance_range = 0.05;
  Forced forced = Forced::No;
  std::vector<std::shared_ptr<const Skin>> skins;

  // After model and world are filled in.
  void finish(const std::vector<int>& person_roots);
  int person_count() const { return (int)drives_.size(); }
  int person_qpos(int p) const { return drives_[p].first_qpos(); }
  int person_qpos_count(int p) const { return drives_[p].qpos_count(); }
  Drive& person(int p) { return drives_[p]; }
  int ball_count() const;  // of all people, roots included
  // What the drives exert on all balls, mean over the last frame [N m] (3 ball_count()), in the children's
  // frames, appended to `out`; nothing, and false, if it is zero.
  bool torques(std::vector<double>& out) const;

  // The pose to start from; people must be at their targets. Objects keep qvel.
  void reset(const double* qpos, const double* qvel);
  // One frame of length dt in n substeps. `targets`: the people's qpos, one after the other.
  // With `poses`, the committed pose of every substep is appended to it.
  void frame(const double* targets, double dt, int n, std::vector<double>* poses = nullptr);

  // In somebody else's world (hosted.cpp): another engine moves all that is no person and says, substep
  // by substep, where it is and which velocity it would have without the people. One frame of length
  // dt: begin, its substeps, end.
  void begin_hosted(const double* targets, double dt);
  // Substep k of length h from `qpos`, `qvel` (people's entries are not read). `free`: the others'
  // velocity at its end without people; `damping`: of their joints, implicit, per dof.
  void substep_hosted(int k, double h, const double* qpos, const double* qvel, const double* free,
                      const double* damping);
  void end_hosted();
  // Per body that is a root: has its tree been touched in the substep before (a person's: in the frame)?
  const std::vector<char>& disturbed() const { return disturbed_; }

  const std::vector<double>& qpos() const { return qpos_; }
  const std::vector<double>& qvel();
  const std::vector<Touch>& touches() const { return touches_; }
  const Diagnostics& diagnostics() const { return diagnostics_; }
  double clearance();  // of the present pose
  // Of any poses (poses x nq): distance and nearest static of every shape (poses x shapes), see
  // World::clearances. The simulation goes on as if nobody had asked.
  void clearances(const double* qpos, size_t poses, double range, double* dist,
                  int* nearest) const;

  // A thing whose poses are given (moving.cpp); after model is filled in.
  void add_track(Track track);
  // A thing that is held where it is until something that moves touches it.
  void start_asleep(int body);
  // The six velocities of a thing, which wakes.
  void set_velocity(int body, const double* six);
  // After reset() at the poses of `old`: goes on as it would. `body` and `shape` say whose numbers they
  // are in `old` (-1: new); the same people and statics in both.
  void adopt(Stepper& old, const std::vector<int>& body, const std::vector<int>& shape);

  std::vector<double> save();
  void load(const std::vector<double>& state);

  // The last substep's problem and answer, for comparison with the reference.
  struct Trace {
    std::vector<double> qpos, qvel, v_free, v;
    std::vector<Contact> contacts;
    std::vector<char> touched;
    double h = 0;
    int k = 0;
    // Velocities of the rounds before the last, in which a joint was to exert more than it can; nv each.
    std::vector<double> overcome;
  };
  bool keep_trace = false;
  Trace trace;
  // Recorded poses are those of every piece of a step too, for judges from outside; nobody follows
  // the motion without steps then.
  bool keep_pieces = false;
  // Wall time of the solver in every substep since the last reset [s], where asked for.
  bool keep_times = false;
  std::vector<double> solve_times;

 private:
  // Poses that are set (forced.cpp).
  void force_frame(const double* targets, double dt, int n, std::vector<double>* poses);
  void put_people(double share);
  void leave_people();
  void push_out(double h);
  void set_push(double h);
  void jam(int tree);
  double fastest(int body, const std::vector<Twist>& twists) const;

  void start_pose();
  bool comes_out(const Drive& d) const;  // of something that the person started inside
  // Marks the trees that have to be stepped through; the others' end of frame is in q_free_.
  void find_busy(double dt, std::vector<char>& busy);
  void sweep_of(const Drive& d, double dt, const std::vector<char>& busy);
  int parts_of(double h) const;
  void substeps(double dt, int n, std::vector<double>* poses);
  void restore(const std::vector<double>& state);
  double speed_bound(const CollisionShape& m, const std::vector<Twist>& t) const;
  int tree(int shape) const { return model.root[world.shapes[shape].body]; }

  // Without contact (free_motion.cpp).
  void free_velocity(int k, double h);
  void object_velocity(double h, const std::vector<char>* only = nullptr);  // per body
  void build_inertia(double h);
  void stiffen();

  // Forces of people that the paper leaves out (ablations.cpp).
  void damp_joints(double h);
  void own_forces(double h);
  void limit_own();
  void discount_own(const Drive& d, const double* v, double h);

  // What people hold, what it asks of the drives, and what is more than those can do (holding.cpp).
  void find_carried();
  bool carries(const Drive& d) const { return carried_[d.body(0)]; }
  void find_load(double h);
  void add_drift(const Drive& d, double h, const std::vector<double>& held,
                 const std::vector<double>& own, double sign);
  void bear_load(double h);
  void bear(const Drive& d, double h);

  // What nothing touches (untouched.cpp).
  void forget_touched();
  // Bodies of people that a contact of this pair concerns.
  void for_touched(const ContactCandidate& c, const std::function<void(int)>& each) const;
  bool find_touched();
  SolveReport answer_touched(double h);
  void hold_untouched();

  // What the drive exerts (strength.cpp).
  void limit_strength(double h);
  bool cut(const Drive& d, double h, double* impulse) const;
  bool exertion(const Drive& d, const double* v, double h);
  bool give_in(double h);
  void added(const Drive& d, double h, const double* x, double* out);
  void tally(double h);
  // out = M x on one person's rows.
  void weigh(const Drive& d, const double* x, double* out) const;

  // With it (substep.cpp).
  void substep(int k, double h);
  void attempt(double h);
  void emerge(double h);  // with hurled() in emerging.cpp
  void try_step(double h);
  // By how much the fastest point of those who come out of something is faster than asked [m/s].
  double hurled();
  void solve(double h);
  // What the contacts make of v_free_: v_ and their impulses (self_answer.cpp).
  SolveReport answer(double h);
  bool solve_self(double h);
  bool touches_itself(const Contact& c) const;
  bool leaves_itself(const ContactCandidate& c) const {
    return c.dist < 0 && c.other_shape >= 0 && tree(c.shape) == tree(c.other_shape);
  }
  void make_room(int a, int b, bool whole);
  void push(const Contact& c, std::vector<double>& f) const;
  // World::excess of candidate i; asks for what a plane that it forgives had hidden.
  double excess(size_t i, double h);
  double allowed(const ContactCandidate& c) const;
  bool verify(double h, int pass, double& worst);
  double approach(const Contact& c, const std::vector<Twist>& twists,
                  const std::vector<double>& v) const;
  bool within_limits(double h) const;
  void drop_idle();
  bool give_way();
  void relax();
  bool bounce(double h, bool good, double& worst);
  void find_islands();
  int island(const ContactCandidate& c) const;

  // A step in pieces (pieces.cpp).
  std::vector<double> shares(double h);
  void commit(double h, const std::vector<double>& share);
  double retry(double h, std::vector<double> share);
  double catch_up(double h, double left, bool begun);

  bool is_person(int body) const { return person_[model.root[body]]; }
  // Things whose velocity is given (moving.cpp).
  void given_velocity(double h);
  double pass_time(double h);
  void set_pace();
  bool slow_down(double h);
  void squeeze();
  void slip_out();
  double moving_mass() const;
  bool wake_touched();
  void wake(int body);

  // The parts of a substep.
  void pose_at(const std::vector<double>& v, double h, Poses& out, std::vector<double>& q);
  void warm_start(Contact& c);
  void bend_way(Contact& c);  // curvature.cpp
  void remember(const std::vector<double>& share);

  std::vector<Drive> drives_;
  std::vector<char> person_;  // per body: the root of one
  bool pose_known_ = false;  // start_ is the pose of qpos_
  Sweep sweep_;
  std::vector<double> q_free_, angular_, spin_bound_, turn_bound_, speed_bound_;
  std::vector<char> way_out_;  // per body: between a root and what started inside something
  std::vector<double> joint_reach_;  // per body: how far any point that its joint moves is [m]
  std::vector<char> busy_, settled_, disturbed_;  // busy and disturbed: per body
  std::vector<double> q_start_, fastest_;
  std::vector<double>* record_ = nullptr;  // of the frame under way
  std::vector<double> assumed_;  // per shape: what the others' sweeps allow it to travel [m]
  const double* hosted_free_ = nullptr;  // of the substep under way
  std::vector<double> hosted_damping_;   // per dof [N s/m, N m s]; empty: nobody hosts
  std::vector<int> objects_;  // bodies with a free joint that are no person's root
  std::vector<double> resist_;  // M^ without M, as factored last
  std::vector<double> v_star_, change_, pushed_, exerted_;
  // In the substep under way: rounds in which a drive gave in (per drive), the share of M^ - M that is left
  // (per dof, of either side), and M^ without M before.
  std::vector<int> overcome_;
  std::vector<double> share_, stiff_, softer_;
  std::vector<char> carried_;  // per body: what people hold, and the roots of those who hold something
  std::vector<double> load_;  // per dof: generalised force
  std::vector<double> own_impulse_;  // per dof: of internal forces in the substep under way
  std::vector<double> qpos_, qvel_, v_free_, v_, spin_, extra_, scale_, torque_, moved_,
      q_end_;
  Poses start_, end_;
  Poses followed_;  // the start of the frame, for those who follow their motion
  Inertia inertia_;
  bool inertia_ready_ = false, factored_ = false;  // M is known; and M^ factored
  // Per body: contacts have pushed it, or what hangs on it, lately or in this attempt; in this substep.
  std::vector<char> touched_, pushed_now_, let_go_;
  std::vector<char> holds_;  // per drive: what is not touched is held
  std::vector<Twist> twists_, moving_;
  std::vector<Twist> turning_;  // what moving_ becomes with time; empty: not asked for yet
  std::vector<double> reach_, way_;
  std::vector<ContactCandidate> candidates_;
  std::vector<Contact> contacts_;
  std::vector<Contact> limits_;  // of joints: they take part in every solve, and their rows are exact
  std::vector<double> pull_;     // what forces gave to articulated dofs in this substep
  // Of an attempt at a step.
  bool good_ = true;       // nothing is violated at its end
  double worst_ = 0;       // most that is [m], negative
  double work_ = 0;        // of its solves
  double tolerance_ = 0;   // of its solves [m]
  size_t solved_ = 0;      // contacts that the last solve knew
  double step_ = 0;        // the whole substep's length [s]
  double pulled_ = 0;      // gravity has acted for this long since the start pose [s]
  std::vector<char> violated_, recalled_;  // per candidate
  double overdue_ = 0;               // the worst violation that solving should have cured [m]
  std::vector<int> island_;          // per body: of the tree that it belongs to
  std::vector<char> gave_way_;       // per body: its tree's clearance has
  std::vector<CachedContact> warm_, next_warm_;
  ContactSolver solver_;
  // What people do to themselves.
  std::vector<char> gives_;      // per dof
  Inertia giving_;
  std::vector<Contact> own_;
  std::vector<double> v_self_;
  std::vector<Twist> self_twists_;
  std::vector<Track> tracks_;
  std::vector<double> clock_;         // per track: where on it the thing is [s]
  // Per track: how fast it goes on, as a share of what is asked, where it squeezes somebody; and when it
  // stands, how many substeps it waits before it tries again, and waits after that.
  struct Pace {
    double share = 1;
    int wait = 0, patience = 0;
  };
  std::vector<Pace> pace_;
  // Per body: of things that people whose poses are set overlap and that had no room to leave, how long they are
  // not pushed, and will not be the next time [s].
  struct Push {
    double wait = 0, patience = 0;
  };
  std::vector<Push> push_;
  std::vector<int> jammed_;  // bodies, in the attempt under way
  bool crushed_ = false;  // the last solve found that something on a track leaves others no room
  std::vector<double> behind_;        // per body: time lost in the substep under way [s]
  std::vector<int> start_asleep_;     // bodies
  std::vector<Touch> touches_;
  Diagnostics diagnostics_;
};

}  // namespace hp
