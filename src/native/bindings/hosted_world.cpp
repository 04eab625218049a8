// People in a MuJoCo world: its arrays and its mj_step, which is called by its address, so that a
// step needs the interpreter only before and after. Nothing links to MuJoCo's library.
#include <atomic>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <thread>

#include "assembly/model_check.h"
#include "bindings/stepper.h"

using namespace hp;

namespace {

using Floats = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
using EngineStep = void (*)(const void* model, void* data);
using EngineError = void (*)(const char* message);

// MuJoCo's errors end the process where nobody catches them. Ours are caught as its own Python
// package does it: by a jump out of its C code.
struct Caught {
  std::jmp_buf out;
  char message[1024];
};
thread_local Caught* catching = nullptr;
EngineError error_before = nullptr;

void on_error(const char* message) {
  if (catching) {
    std::strncpy(catching->message, message, sizeof catching->message - 1);
    std::longjmp(catching->out, 1);
  }
  if (error_before) return error_before(message);
  std::fprintf(stderr, "ERROR: %s\n\n", message);
  std::exit(EXIT_FAILURE);
}

// `handler`: the address of mju_user_error.
void catch_engine_errors(uintptr_t handler) {
  EngineError& at = *reinterpret_cast<EngineError*>(handler);
  if (at == on_error) return;
  error_before = at;
  at = on_error;
}

// A MuJoCo model and data with people in them. The arrays stay MuJoCo's; Python keeps them.
struct HostedWorld {
  Stepper& stepper;
  Host host;
  void *model = nullptr, *data = nullptr;  // mjModel, mjData
  EngineStep engine = nullptr;
  std::vector<double> targets;
  int n = 0;
  double h = 0;
  bool watched = false;  // something of the host's hangs on people's mirrors
  bool begun = false;
  std::string error;

  explicit HostedWorld(Stepper& s) : stepper(s) {}

  void begin(bool watched) {
    stepper.begin_hosted(host, targets.data(), n, h, watched);
    begun = true;
  }
  void end() {
    stepper.end_hosted();
    begun = false;
  }
  // Frames without the interpreter: false, and `error` says why, where MuJoCo gave up.
  bool run() {
    begin(watched);
    for (int k = 0; k < n; k++) {
      stepper.before_hosted(k);
      if (!call()) return false;
      stepper.after_hosted(k);
    }
    end();
    return true;
  }

 private:
  bool call() {
    static thread_local Caught caught;
    catching = &caught;
    if (setjmp(caught.out)) {
      catching = nullptr;
      error = caught.message;
      return false;
    }
    engine(model, data);
    catching = nullptr;
    return true;
  }
};

double* of_length(const Floats& a, size_t n, const char* what) {
  need(a.size() == n, what);
  return a.data();
}

void set_arrays(HostedWorld& w, Floats qpos, Floats qvel, Floats qacc, Floats damping, Floats xipos,
                Floats applied, Floats mocap_pos, Floats mocap_quat, Ints bodies, Ints mirrors) {
  const Model& m = w.stepper.system.model;
  Host& h = w.host;
  h.nq = (int)qpos.size(), h.nv = (int)qvel.size();
  const size_t all = xipos.size() / 3;
  h.bodies = list<int>(bodies);
  const int own = (int)h.bodies.size();
  need(h.nq <= m.nq && h.nv <= m.nv && own < m.nbody, "set_arrays: not of this model");
  for (int b : h.bodies) need(b > 0 && b < (int)all, "set_arrays: no such body");
  const char* bad = "set_arrays: bad length";
  h.qpos = qpos.data(), h.qvel = qvel.data(), h.xipos = xipos.data();
  h.qacc = of_length(qacc, h.nv, bad), h.damping = of_length(damping, h.nv, bad);
  h.applied = of_length(applied, 6 * all, bad);
  const size_t mocap = mocap_pos.size() / 3;
  h.mocap_pos = mocap_pos.data(), h.mocap_quat = of_length(mocap_quat, 4 * mocap, bad);
  h.mirrors.clear();
  for (size_t i = 0; i + 1 < mirrors.shape(0); i += 2) {
    const int body = mirrors.data()[i], row = mirrors.data()[i + 1];
    need(body > own && body < m.nbody && row >= 0 && row < (int)mocap,
         "set_arrays: no such mirror");
    h.mirrors.push_back({body, row});
  }
}

// What the host reads of its model in every step: of its bodies in the core, of its dofs, and gravity.
void set_masses(HostedWorld& w, Doubles mass, Rows3 inertia, Rows3 ipos, Rows4 iquat,
                Doubles armature, Doubles gravity) {
  System& system = w.stepper.system;
  const size_t n = w.host.bodies.size();
  need(mass.shape(0) == n && inertia.shape(0) == n && ipos.shape(0) == n && iquat.shape(0) == n &&
           (int)armature.shape(0) == w.host.nv && gravity.shape(0) == 3,
       "set_masses: bad length");
  Model changed = system.model;
  const std::vector<Vec3> moments = vectors(inertia), centres = vectors(ipos);
  const std::vector<Quat> turns = quats(iquat);
  for (size_t i = 0; i < n; i++) {
    changed.mass[i + 1] = mass.data()[i];
    changed.inertia[i + 1] = moments[i], changed.ipos[i + 1] = centres[i];
    changed.iquat[i + 1] = turns[i];
  }
  std::copy_n(armature.data(), w.host.nv, changed.armature.begin());
  assembly::check_model(changed);
  changed.add_up_masses();
  system.model = std::move(changed);
  system.gravity = load3(gravity.data());
}

void aim(HostedWorld& w, Doubles targets, int n, double h) {
  need((int)targets.shape(0) == target_count(w.stepper), "aim: bad length of targets");
  need(n > 0 && h > 0, "aim: no time");
  w.targets = list<double>(targets);
  w.n = n, w.h = h;
}

// All worlds, each aimed; on at most `threads` threads. Each is stepped by one thread alone, so the
// answer is the same for any number of them. Returns the errors, "" where there was none.
std::vector<std::string> run_worlds(const std::vector<HostedWorld*>& worlds, int threads) {
  for (HostedWorld* w : worlds) {
    need(w->engine && w->n > 0, "run_worlds: a world that has no engine or no aim");
    w->error.clear();
  }
  nb::gil_scoped_release release;
  std::atomic<size_t> next{0};
  auto work = [&] {
    for (size_t i; (i = next++) < worlds.size();) {
      try {
        worlds[i]->run();
      } catch (const std::exception& error) {  // none may leave a thread
        worlds[i]->error = error.what();
      }
    }
  };
  std::vector<std::thread> pool;
  try {
    for (int i = 1; i < std::min(threads, (int)worlds.size()); i++) pool.emplace_back(work);
  } catch (const std::system_error&) {  // fewer threads than asked for
  }
  work();
  for (std::thread& t : pool) t.join();
  std::vector<std::string> errors;
  for (HostedWorld* w : worlds) errors.push_back(w->error);
  return errors;
}

// Columns: shape, other static, other shape, gap, position, normal, impulse; of the last timestep.
auto points(const Stepper& s) {
  std::vector<double> out;
  for (const FrameResult::Point& p : s.result().points) {
    out.insert(out.end(), {(double)p.shape, (double)p.other_static, (double)p.other_shape, p.dist});
    push(out, p.position);
    push(out, p.normal);
    push(out, p.impulse);
  }
  const size_t rows = out.size() / 13;
  return array({rows, 13}, out);
}

}  // namespace

void bind_hosted_world(nb::module_& m) {
  m.def("catch_engine_errors", &catch_engine_errors);
  m.def("run_worlds", &run_worlds);
  nb::class_<HostedWorld>(m, "HostedWorld")
      .def(nb::init<Stepper&>(), nb::keep_alive<1, 2>())
      .def("set_arrays", &set_arrays)
      .def("set_engine",
           [](HostedWorld& w, uintptr_t step, uintptr_t model, uintptr_t data, bool watched) {
             w.engine = reinterpret_cast<EngineStep>(step);
             w.model = reinterpret_cast<void*>(model);
             w.data = reinterpret_cast<void*>(data);
             w.watched = watched;
           })
      .def("set_masses", &set_masses)
      .def("start", [](HostedWorld& w) { w.stepper.start_hosted(w.host); })
      .def("aim", &aim)
      .def("run",
           [](HostedWorld& w) {
             need(w.engine && w.n > 0, "run: no engine or no aim");
             w.error.clear();
             nb::gil_scoped_release release;
             w.run();
           })
      .def_prop_ro("error", [](const HostedWorld& w) { return w.error; })
      // The same, timestep by timestep, for a caller who makes them.
      .def(
          "begin", [](HostedWorld& w) { w.begin(true); }, nb::call_guard<nb::gil_scoped_release>())
      .def("before",
           [](HostedWorld& w, int k) {
             need(w.begun && k >= 0 && k < w.n, "before: no such timestep");
             w.stepper.before_hosted(k);
           })
      .def("after",
           [](HostedWorld& w, int k) {
             need(w.begun && k >= 0 && k < w.n, "after: no such timestep");
             nb::gil_scoped_release release;
             w.stepper.after_hosted(k);
           })
      .def("end",
           [](HostedWorld& w) {
             need(w.begun, "end: no frame has begun");
             w.end();
           })
      // What set_state needs: forces of ours among the host's, and people shown again.
      .def("forces",
           [](const HostedWorld& w) {
             const std::vector<double> out = w.stepper.hosted_forces();
             return array({out.size() / 13, 13}, out);
           })
      .def("set_forces",
           [](HostedWorld& w, Square rows) {
             need(rows.shape(0) == 0 || rows.shape(1) == 13, "set_forces: expected (n, 13)");
             const size_t count = rows.shape(0) * 13;
             for (size_t i = 0; i < count; i += 13)
               need(
                   std::count(w.host.bodies.begin(), w.host.bodies.end(), (int)rows.data()[i]) == 1,
                   "set_forces: no such body");
             w.stepper.set_hosted_forces({rows.data(), rows.data() + count});
           })
      .def("show", [](HostedWorld& w) { w.stepper.show_hosted(w.host); })
      .def("pushes", [](const HostedWorld& w) { return !w.stepper.result().points.empty(); })
      .def("points", [](const HostedWorld& w) { return points(w.stepper); });
}
