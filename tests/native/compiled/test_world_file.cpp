// The reader of world files: what it refuses, and that no size in a file makes it take memory.
#include "compiled/world_file.h"

#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>

#include "check.h"
#include "compiled/crc32.h"

namespace {

size_t taken = 0;  // bytes since the last reset of the counter

}  // namespace

void* operator new(size_t size) {
  taken += size;
  void* p = std::malloc(size);
  if (!p) throw std::bad_alloc();
  return p;
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, size_t) noexcept { std::free(p); }

namespace {

struct Bytes {
  std::string text;
  template <typename T>
  Bytes& put(T value) {
    text.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Bytes& name(const char* name) {
    char padded[24] = {};
    std::strncpy(padded, name, sizeof padded);
    text.append(padded, sizeof padded);
    return *this;
  }
};

// A file of a body, with a header that fits it.
std::string file(const std::string& body, uint32_t calls, uint32_t version = 1) {
  Bytes out;
  out.text = std::string("\x89HPW\r\n\x1a\n", 8);
  out.put(version).put(hp::crc32(reinterpret_cast<const unsigned char*>(body.data()), body.size()));
  out.put((uint64_t)body.size()).put(calls).put((uint32_t)0);
  return out.text + body;
}

// One call with one argument.
std::string call(uint32_t arguments, uint32_t type, uint32_t dims, uint64_t a, uint64_t b,
                 uint64_t c, const std::string& data) {
  Bytes out;
  out.put(arguments).put((uint32_t)0).name("call");
  out.name("values").put(type).put(dims).put(a).put(b).put(c);
  return out.text + data;
}

// What the reader says of bytes; "": it takes them. It takes no more memory than twice the bytes and a little.
std::string said(const std::string& bytes) {
  taken = 0;
  std::string what;
  try {
    const hp::WorldFile read(bytes.data(), bytes.size());
  } catch (const std::invalid_argument& error) {
    what = error.what();
  }
  CHECK(taken < 2 * bytes.size() + 4096);
  return what;
}

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

void whole_files() {
  const std::string values(16, '\0'), good = file(call(1, 2, 1, 2, 1, 1, values), 1);
  CHECK(said(good).empty());
  const hp::WorldFile read(good.data(), good.size());
  CHECK(read.calls().size() == 1 && read.calls()[0].name == "call");
  const hp::Argument& argument = read.calls()[0].arguments.at(0);
  CHECK(argument.name == "values" && argument.count() == 2 && argument.dims == 1);
  CHECK(reinterpret_cast<uintptr_t>(argument.data) % 8 == 0);
  // From where it lies in memory nothing depends.
  const std::string shifted = "x" + good;
  CHECK(hp::WorldFile(shifted.data() + 1, good.size()).checksum() == read.checksum());
  CHECK(said(file("", 0)).empty());
}

void damaged_files() {
  const std::string values(16, '\0'), good = file(call(1, 2, 1, 2, 1, 1, values), 1);
  for (size_t length = 0; length < good.size(); length++)
    CHECK(!said(good.substr(0, length)).empty());
  for (size_t i = 0; i < 8 * good.size(); i++) {
    std::string bad = good;
    bad[i / 8] = (char)(bad[i / 8] ^ (1 << i % 8));
    // Of the number of calls and the last four bytes of the header no checksum is made.
    CHECK(!said(bad).empty() || i / 8 >= 28);
    if (i / 8 >= 32) CHECK(!said(bad).empty());
  }
  CHECK(has(said(good + std::string(8, '\0')), "its size is not"));
  CHECK(has(said("PK\x03\x04 a zip"), "this is no world file"));
  CHECK(has(said(file(call(1, 2, 1, 2, 1, 1, values), 1, 2)), "found layout 2, expected 1"));
}

// With a checksum that fits, as a stranger would write it.
void impossible_sizes() {
  const std::string values(16, '\0');
  const uint64_t huge = ~uint64_t{0}, half = uint64_t{1} << 33;
  CHECK(has(said(file(call(1, 2, 1, huge, 1, 1, values), 1)), "impossible size"));
  CHECK(has(said(file(call(1, 2, 2, half, half, 1, values), 1)), "impossible size"));
  CHECK(has(said(file(call(1, 2, 3, 1 << 20, 1 << 20, 1 << 20, values), 1)), "impossible size"));
  CHECK(has(said(file(call(1, 2, 1, 3, 1, 1, values), 1)), "ends too early"));
  CHECK(has(said(file(call(1, 2, 1, 1, 1, 1, values), 1)), "more in it"));
  CHECK(has(said(file(call(1, 2, 1, 2, 2, 1, values), 1)), "another shape"));
  CHECK(has(said(file(call(1, 9, 1, 2, 1, 1, values), 1)), "no known type"));
  CHECK(has(said(file(call(1, 2, 4, 2, 1, 1, values), 1)), "more than three dimensions"));
  CHECK(has(said(file(call(~0u, 2, 1, 2, 1, 1, values), 1)), "ends too early"));
  CHECK(has(said(file(call(1, 2, 1, 2, 1, 1, values), ~0u)), "ends too early"));
  CHECK(has(said(file(std::string(64, 'x'), 1)), "a name has no end"));
}

}  // namespace

int main() {
  whole_files();
  damaged_files();
  impossible_sizes();
  return check::report("test_world_file");
}
