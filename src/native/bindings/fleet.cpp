// Many worlds side by side: one frame of each in one call, on threads that never touch the
// interpreter. For environments of robots and people, which look at a few bodies, motors and contacts
// of every world after every frame.
//
// What is looked at in a world has the same size in all, wherever it stands in that world:
//     bodies  (B)      poses (position, quaternion) in the world
//     motors  (M)      coordinates and velocities
//     groups  (G)      of shapes: impulses (G, G, 4) of one group on another in the frame: the sum [N s]
//                      and the sum of lengths; a pair of one group counts once
// No world's numbers depend on the others, nor on the number of threads.
#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>

#include "bindings/stepper.h"

using namespace hp;

namespace {

struct Watched {
  Stepper* stepper = nullptr;
  nb::object keeper;                                   // keeps it alive
  std::vector<int> bodies, shape_group, static_group;  // groups: -1: none
  Kinematics kin;                                      // of its own: looking changes nothing
};

class Fleet {
 public:
  Fleet(int worlds, int threads, int bodies, int motors, int groups)
      : bodies_(bodies), motors_(motors), groups_(groups), worlds_(worlds > 0 ? worlds : 0) {
    need(worlds > 0 && threads > 0, "Fleet: expected at least one world and one thread");
    need(bodies >= 0 && motors >= 0 && groups >= 0, "Fleet: expected sizes of 0 or more");
    try {
      for (int i = 1; i < threads; i++) pool_.emplace_back([this] { work(); });
    } catch (const std::system_error&) {  // the caller's thread does the rest
    }
  }
  ~Fleet() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopped_ = true;
      wake_.notify_all();
    }
    nb::gil_scoped_release release;
    for (std::thread& thread : pool_) thread.join();
  }
  Fleet(const Fleet&) = delete;
  Fleet& operator=(const Fleet&) = delete;

  // World `i` is this stepper's from now on. `effort`: per motor.
  void put(int i, nb::object stepper, Ints bodies, Ints motors, Doubles effort, Ints shape_group,
           Ints static_group) {
    need(i >= 0 && i < (int)worlds_.size(), "put: no such world");
    Stepper& s = nb::cast<Stepper&>(stepper);
    const Model& m = s.system.model;
    need((int)bodies.shape(0) == bodies_ && (int)motors.shape(0) == motors_ &&
             effort.shape(0) == motors.shape(0),
         "put: bad number of bodies or motors");
    need(shape_group.shape(0) == s.system.world.shapes.size() &&
             static_group.shape(0) == s.system.world.statics.size(),
         "put: bad number of shapes");
    Watched w;
    w.stepper = &s, w.keeper = std::move(stepper);
    w.bodies = list<int>(bodies);
    w.shape_group = list<int>(shape_group), w.static_group = list<int>(static_group);
    for (int b : w.bodies) need(b >= 0 && b < m.nbody, "put: no such body");
    for (const std::vector<int>* groups : {&w.shape_group, &w.static_group})
      for (int g : *groups) need(g >= -1 && g < groups_, "put: no such group");
    w.kin.resize(m);
    s.system.articulations.set_motors(m, list<int>(motors), list<double>(effort));
    worlds_[i] = std::move(w);
  }

  // One frame of length dt in n substeps of the worlds in which `active` is not 0. `targets`
  // (worlds, .): of all people of a world; `rests` and their velocities `rates` (worlds, motors). All
  // of `poses` (worlds, 7 bodies), `states` (worlds, 2 motors: coordinates, then velocities) and `impulses` (worlds, 4 groups groups)
  // that belongs to an active world is written; n = 0: nobody moves, impulses are zero.
  void frame(Ints active, Square targets, Square rests, Square rates, double dt, int n, Out poses,
             Out states, Out impulses) {
    const size_t count = worlds_.size();
    for (size_t rows : {active.shape(0), targets.shape(0), rests.shape(0), rates.shape(0),
                        poses.shape(0), states.shape(0), impulses.shape(0)})
      need(rows == count, "frame: expected one row per world");
    need((int)rests.shape(1) == motors_ && (int)rates.shape(1) == motors_ &&
             (int)poses.shape(1) == 7 * bodies_ && (int)states.shape(1) == 2 * motors_ &&
             (int)impulses.shape(1) == 4 * groups_ * groups_,
         "frame: bad shape of rests, rates, poses, states or impulses");
    need(n >= 0 && dt > 0, "frame: expected a length, and a number of substeps");
    for (size_t i = 0; i < count; i++)
      need(!active.data()[i] ||
               (worlds_[i].stepper && (int)targets.shape(1) == target_count(*worlds_[i].stepper)),
           "frame: a world that is not there, or a bad length of targets");
    nb::gil_scoped_release release;
    run([&](size_t i) {
      if (!active.data()[i]) return;
      Watched& w = worlds_[i];
      if (n > 0) {
        w.stepper->system.articulations.set_rests(
            w.stepper->system.model, rests.data() + i * motors_, rates.data() + i * motors_);
        w.stepper->frame(targets.data() + i * targets.shape(1), dt, n);
      }
      look(w, poses.data() + i * poses.shape(1), states.data() + i * states.shape(1));
      tally(w, n > 0, impulses.data() + i * impulses.shape(1));
    });
  }

 private:
  void look(Watched& w, double* poses, double* states) const {
    Stepper& s = *w.stepper;
    const Model& m = s.system.model;
    w.kin.update(m, s.qpos().data());
    for (int b = 0; b < bodies_; b++) {
      const Vec3 x = w.kin.xpos[w.bodies[b]];
      const Quat q = w.kin.xquat[w.bodies[b]];
      for (double v : {x.x, x.y, x.z, q.w, q.x, q.y, q.z}) *poses++ = v;
    }
    const std::vector<int>& motors = s.system.articulations.joints.motors;
    const std::vector<double>& qvel = s.qvel();
    for (int k = 0; k < motors_; k++) {
      states[k] = s.qpos()[m.jnt_qpos[motors[k]]];
      states[motors_ + k] = qvel[m.jnt_dof[motors[k]]];
    }
  }

  void tally(const Watched& w, bool moved, double* out) const {
    std::fill(out, out + 4 * groups_ * groups_, 0.0);
    if (!moved) return;
    for (const Touch& t : w.stepper->result().touches) {
      const int a = w.shape_group[t.shape];
      const int b =
          t.other_static >= 0 ? w.static_group[t.other_static] : w.shape_group[t.other_shape];
      if (a < 0 || b < 0) continue;
      add(out + 4 * (a * groups_ + b), t.impulse);
      if (a != b) add(out + 4 * (b * groups_ + a), -t.impulse);
    }
  }

  static void add(double* out, Vec3 impulse) {
    for (int c = 0; c < 3; c++) out[c] += impulse[c];
    out[3] += norm(impulse);
  }

  template <typename Task>
  void run(const Task& task) {
    std::unique_lock<std::mutex> lock(mutex_);
    need(!task_, "frame: another thread is in it");
    task_ = task;
    next_ = 0, inside_ = 0, error_ = nullptr;
    wake_.notify_all();
    inside_++;
    lock.unlock();
    take();
    lock.lock();
    inside_--;
    done_.wait(lock, [&] { return inside_ == 0; });
    task_ = nullptr;
    if (error_) std::rethrow_exception(error_);
  }

  // Worlds one after the other, as long as there are any.
  void take() {
    for (size_t i; (i = next_++) < worlds_.size();) {
      try {
        task_(i);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (!error_) error_ = std::current_exception();
      }
    }
  }

  void work() {
    for (;;) {
      std::unique_lock<std::mutex> lock(mutex_);
      wake_.wait(lock, [&] { return stopped_ || (task_ && next_ < worlds_.size()); });
      if (stopped_) return;
      inside_++;
      lock.unlock();
      take();
      lock.lock();
      inside_--;
      if (inside_ == 0) done_.notify_all();
    }
  }

  int bodies_, motors_, groups_;
  std::vector<Watched> worlds_;
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  std::function<void(size_t)> task_;
  std::atomic<size_t> next_{0};
  int inside_ = 0;  // threads that take worlds
  std::exception_ptr error_;
  bool stopped_ = false;
  std::vector<std::thread> pool_;
};

}  // namespace

void bind_fleet(nb::module_& m) {
  using namespace nb::literals;
  nb::class_<Fleet>(m, "Fleet")
      .def(nb::init<int, int, int, int, int>(), "worlds"_a, "threads"_a, nb::kw_only(), "bodies"_a,
           "motors"_a, "groups"_a)
      .def("put", &Fleet::put, "world"_a, "stepper"_a, nb::kw_only(), "bodies"_a, "motors"_a,
           "effort"_a, "shape_group"_a, "static_group"_a)
      .def("frame", &Fleet::frame, nb::kw_only(), "active"_a, "targets"_a, "rests"_a, "rates"_a,
           "dt"_a, "substeps"_a, "poses"_a, "states"_a, "impulses"_a);
}
