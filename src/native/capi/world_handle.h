// What an hp_world is, and how its functions report failures: shared by the files of this folder.
#pragma once
#include <memory>
#include <stdexcept>
#include <string>

#include "capi/halfphysics.h"
#include "compiled/compiled_world.h"

struct hp_world {
  std::unique_ptr<hp::CompiledWorld> compiled;
  std::vector<std::string> body_names;
  bool started = false;
  double dt = 0;  // of the last frame [s]; 0: there was none

  hp::Stepper& stepper() { return compiled->stepper; }
  const hp::Labels& labels() const { return compiled->labels; }
};

namespace hp::capi {

// A failure with its status; what it says is what hp_error() gives.
struct Failure : std::runtime_error {
  Failure(hp_status status, const std::string& what) : std::runtime_error(what), status(status) {}
  hp_status status;
};

inline void need(bool ok, hp_status status, const std::string& what) {
  if (!ok) throw Failure(status, what);
}

// Keeps a message for hp_error() and returns `status`.
hp_status failed(hp_status status, const char* what) noexcept;

// What `work` throws as a status; no exception leaves. `invalid`: what std::invalid_argument stands for.
template <typename Work>
hp_status guarded(Work work, hp_status invalid = HP_BAD_ARGUMENT) noexcept {
  try {
    work();
    return HP_OK;
  } catch (const Failure& failure) {
    return failed(failure.status, failure.what());
  } catch (const std::invalid_argument& error) {
    return failed(invalid, error.what());
  } catch (const std::bad_alloc&) {
    return failed(HP_NO_MEMORY, "there is not enough memory");
  } catch (const std::length_error&) {
    return failed(HP_NO_MEMORY, "there is not enough memory");
  } catch (const std::exception& error) {
    return failed(HP_FAILED, error.what());
  }
}

// A world that has been reset. Throws Failure.
hp_world& running(hp_world* world, const char* function);
// `count` finite numbers, none beyond what a length or an angle can be. Throws Failure.
void check_numbers(const double* values, size_t count, const char* name);
// A number over 0, up to `most`. Throws Failure.
void check_positive(double value, double most, const char* name);
// The object of a name, or nullptr with no failure where it is something else. Throws Failure where it is nothing.
ObjectPlace* object(hp_world& world, const char* name, const char* function);
// An object that moves freely. Throws Failure.
ObjectPlace& free_object(hp_world& world, const char* name, const char* function);
// Coordinates of people at poses, into `qpos`, and the same one after the other as the stepper's targets.
void put_poses(const hp_world& world, const double* translation, const double* rotations,
               double* qpos, std::vector<double>* targets);

}  // namespace hp::capi
