// Whole motions, each by a stepper of its own, on threads that never touch the interpreter.
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>

#include "bindings/recording.h"

using namespace hp;

namespace {

// One motion: a start, then its frames. The arrays belong to the caller, who keeps them until the
// job is taken.
struct Job {
  Stepper* stepper = nullptr;
  const double *qpos = nullptr, *qvel = nullptr, *lambda = nullptr;
  Frames frames;
  std::vector<double> start_qpos, start_inside, start_footing;
  double start_clearance = 0;
  Recording recording;
  std::exception_ptr error;
  bool ended = false;

  void run(const std::atomic<bool>& stopped) {
    Stepper& s = *stepper;
    s.reset(qpos, qvel);
    set_stiffness(s, lambda);
    start_qpos = s.qpos();
    start_clearance = s.clearance();
    inside_rows(s.system.world, start_inside);
    s.footing(start_footing);
    while (recording.done < frames.count && !stopped) frames.run(s, recording);
  }
};

class Batch {
 public:
  explicit Batch(int threads) {
    need(threads > 0, "Batch: expected at least one thread");
    try {
      for (int i = 0; i < threads; i++) pool_.emplace_back([this] { work(); });
    } catch (const std::system_error&) {
      if (pool_.empty()) throw;  // the system gives no thread at all
    }
  }
  ~Batch() { close(); }
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;

  void submit(int key, Stepper& s, Doubles qpos, Doubles qvel, Doubles lambda, Square targets,
              double dt, int substeps, bool record, Square stiffness, Out out) {
    const Model& m = s.system.model;
    need((int)qpos.shape(0) == m.nq && (int)qvel.shape(0) == m.nv &&
             (int)lambda.shape(0) == s.system.ball_count(),
         "submit: bad length of qpos, qvel or lambda");
    auto job = std::make_unique<Job>();
    job->stepper = &s;
    job->qpos = qpos.data(), job->qvel = qvel.data(), job->lambda = lambda.data();
    job->frames = Frames::of(s, targets, dt, substeps, record, stiffness, out);
    const std::lock_guard<std::mutex> lock(mutex_);
    need(jobs_.count(key) == 0 && !stopped_, "submit: known already, or the batch is closed");
    jobs_[key] = std::move(job);
    waiting_.push_back(key);
    wake_.notify_one();
  }

  // Keys of the jobs that have ended since the last call; waits for one, `seconds` at most.
  std::vector<int> ended(double seconds) {
    nb::gil_scoped_release release;
    std::unique_lock<std::mutex> lock(mutex_);
    done_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return !ended_.empty(); });
    std::vector<int> keys;
    keys.swap(ended_);
    return keys;
  }

  // What a job that has ended has recorded; throws what it has thrown.
  nb::dict take(int key) {
    std::unique_ptr<Job> job;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      auto found = jobs_.find(key);
      need(found != jobs_.end() && found->second->ended, "take: no such job, or it goes on");
      job = std::move(found->second);
      jobs_.erase(found);
    }
    if (job->error) std::rethrow_exception(job->error);
    nb::dict d = job->recording.dict(*job->stepper);
    d["start_qpos"] = array(job->start_qpos);
    d["start_clearance"] = job->start_clearance;
    d["start_inside"] = array({job->start_inside.size() / 4, 4}, job->start_inside);
    d["start_footing"] = array({job->start_footing.size() / 2, 2}, job->start_footing);
    return d;
  }

  // Ends all threads, at the next frame; jobs that have not ended are lost.
  void close() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopped_ = true;
      wake_.notify_all();
    }
    nb::gil_scoped_release release;
    for (std::thread& thread : pool_) thread.join();
    pool_.clear();
  }

 private:
  void work() {
    for (;;) {
      Job* job;
      int key;
      {
        std::unique_lock<std::mutex> lock(mutex_);
        wake_.wait(lock, [&] { return stopped_ || !waiting_.empty(); });
        if (stopped_) return;
        key = waiting_.front();
        waiting_.pop_front();
        job = jobs_[key].get();
      }
      try {
        job->run(stopped_);
      } catch (...) {
        job->error = std::current_exception();
      }
      const std::lock_guard<std::mutex> lock(mutex_);
      job->ended = true;
      ended_.push_back(key);
      done_.notify_one();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  std::map<int, std::unique_ptr<Job>> jobs_;
  std::deque<int> waiting_;
  std::vector<int> ended_;
  std::atomic<bool> stopped_{false};
  std::vector<std::thread> pool_;
};

}  // namespace

void bind_batch(nb::module_& m) {
  using namespace nb::literals;
  nb::class_<Batch>(m, "Batch")
      .def(nb::init<int>(), "threads"_a)
      .def("submit", &Batch::submit, "key"_a, "stepper"_a, "qpos"_a, "qvel"_a, "lambda_"_a,
           "targets"_a, "dt"_a, "substeps"_a, "record"_a, "stiffness"_a, "out"_a)
      .def("ended", &Batch::ended, "seconds"_a)
      .def("take", &Batch::take, "key"_a)
      .def("close", &Batch::close);
}
