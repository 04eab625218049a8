#include "compiled/arguments.h"

#include <cmath>

namespace hp {

namespace {

// Larger numbers are no lengths, masses or rates.
constexpr double kLargest = 1e12;

// Arguments that may be infinite: there is no limit then.
bool endless(std::string_view name) {
  for (const char* one : {"limits", "lower", "upper", "clearance_range", "root_speed",
                          "recovery_rate", "depenetration_speed"})
    if (name == one) return true;
  return false;
}

}  // namespace

const Argument& Arguments::find(const char* name) const {
  for (const Argument& a : call_.arguments)
    if (a.name == name) return a;
  throw std::invalid_argument("world file: " + std::string(call_.name) + " lacks " + name +
                              "; write the file with the same version of halfphysics");
}

void Arguments::wrong(const Argument& a, const char* expected) const {
  throw std::invalid_argument("world file: " + std::string(call_.name) + ", " +
                              std::string(a.name) + ": expected " + expected +
                              "; the file is damaged: write it again with save_world");
}

void Arguments::expect(const Argument& a, Argument::Type type, uint32_t dims,
                       const char* expected) const {
  if (a.type != type || a.dims != dims) wrong(a, expected);
}

void Arguments::check_numbers(const Argument& a) const {
  const double* v = static_cast<const double*>(a.data);
  for (size_t i = 0; i < a.count(); i++)
    if (!(std::fabs(v[i]) <= kLargest || (std::isinf(v[i]) && endless(a.name))))
      wrong(a, "numbers of a possible size");
}

void Arguments::read(const Argument& a, int& out) const {
  expect(a, Argument::Type::Int, 0, "a whole number");
  out = *static_cast<const int*>(a.data);
}

void Arguments::read(const Argument& a, bool& out) const {
  int number = 0;
  read(a, number);
  out = number != 0;
}

void Arguments::read(const Argument& a, double& out) const {
  expect(a, Argument::Type::Double, 0, "a number");
  check_numbers(a);
  out = *static_cast<const double*>(a.data);
}

void Arguments::read(const Argument& a, std::string& out) const {
  expect(a, Argument::Type::Text, 1, "a text");
  out.assign(static_cast<const char*>(a.data), a.shape[0]);
}

void Arguments::read(const Argument& a, std::vector<int>& out) const {
  out = list<int>(get<Ints>(std::string(a.name).c_str()));
}

}  // namespace hp
