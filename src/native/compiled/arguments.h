// The arguments of a recorded call by name, as the types that the call takes.
#pragma once
#include <array>
#include <string>
#include <utility>

#include "assembly/array_view.h"
#include "compiled/world_file.h"

namespace hp {

class Arguments {
 public:
  explicit Arguments(const RecordedCall& call) : call_(call) {}

  // The value of an argument: int, bool, double, std::string, std::vector<int>, or an ArrayView. Throws
  // std::invalid_argument where it is missing, of another type or shape, or holds what is not a number.
  template <typename T>
  T get(const char* name) const {
    T out;
    read(find(name), out);
    return out;
  }

 private:
  const Argument& find(const char* name) const;
  [[noreturn]] void wrong(const Argument& a, const char* expected) const;
  void expect(const Argument& a, Argument::Type type, uint32_t dims, const char* expected) const;
  void check_numbers(const Argument& a) const;

  void read(const Argument& a, int& out) const;
  void read(const Argument& a, bool& out) const;
  void read(const Argument& a, double& out) const;
  void read(const Argument& a, std::string& out) const;
  void read(const Argument& a, std::vector<int>& out) const;
  template <typename T, int... Shape>
  void read(const Argument& a, ArrayView<T, Shape...>& out) const {
    constexpr bool whole = std::is_same_v<T, int>;
    expect(a, whole ? Argument::Type::Int : Argument::Type::Double, sizeof...(Shape),
           "an array of other dimensions");
    size_t shape[sizeof...(Shape)];
    for (size_t i = 0; i < sizeof...(Shape); i++) {
      const int fixed = ArrayView<T, Shape...>::kShape[i];
      shape[i] = a.shape[i];
      if (fixed >= 0 && shape[i] != (size_t)fixed) wrong(a, "an array of another shape");
    }
    if (!whole) check_numbers(a);
    out = ArrayView<T, Shape...>(static_cast<const T*>(a.data), shape);
  }

  const RecordedCall& call_;
};

}  // namespace hp
