#include "compiled/world_file.h"

#include <cstring>
#include <stdexcept>

#include "compiled/crc32.h"

namespace hp {

namespace {

constexpr size_t kHeader = 32, kCallHeader = 32, kArgumentHeader = 56;
constexpr size_t kName = 24;
constexpr unsigned char kMagic[8] = {0x89, 'H', 'P', 'W', '\r', '\n', 0x1a, '\n'};
// What sizes of arrays can be as int.
constexpr uint64_t kMostBytes = uint64_t{1} << 31;

[[noreturn]] void broken(const char* what) {
  throw std::invalid_argument(std::string("world file: ") + what +
                              "; the file is damaged: write it again with save_world");
}

template <typename T>
T number(const unsigned char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

struct Cursor {
  const unsigned char *at, *end;

  size_t left() const { return end - at; }
  const unsigned char* take(size_t bytes) {
    if (bytes > left()) broken("it ends too early");
    const unsigned char* here = at;
    at += bytes;
    return here;
  }
  std::string_view name(size_t width) {
    const char* text = reinterpret_cast<const char*>(take(width));
    const size_t length = strnlen(text, width);
    if (length == 0 || length == width) broken("a name has no end");
    return {text, length};
  }
  uint32_t u32() { return number<uint32_t>(take(4)); }
  uint64_t u64() { return number<uint64_t>(take(8)); }
};

Argument argument(Cursor& in) {
  const std::string_view name = in.name(kName);
  const uint32_t type = in.u32();
  if (type < 1 || type > 3) broken("an argument of no known type");
  Argument out{name, static_cast<Argument::Type>(type), in.u32(), {1, 1, 1}, nullptr};
  if (out.dims > 3) broken("an array of more than three dimensions");
  uint64_t count = 1;
  for (uint32_t i = 0; i < 3; i++) {
    const uint64_t length = in.u64();
    if (i >= out.dims && length != 1) broken("an array of another shape than its dimensions");
    if (length > kMostBytes) broken("an impossible size");
    count *= length;
    if (count > kMostBytes) broken("an impossible size");
    out.shape[i] = length;
  }
  const size_t width = type == 1 ? 4 : type == 2 ? 8 : 1;
  if (count * width > in.left()) broken("it ends too early");  // before it is a size_t of 32 bits
  out.data = in.take((count * width + 7) / 8 * 8);
  return out;
}

void check_header(const unsigned char* header, size_t size) {
  if (size < kHeader || std::memcmp(header, kMagic, sizeof kMagic) != 0)
    throw std::invalid_argument(
        "this is no world file: expected one that halfphysics.compile_world or save_world wrote");
  const uint32_t version = number<uint32_t>(header + 8);
  if (version != kWorldFileVersion)
    throw std::invalid_argument("world file: found layout " + std::to_string(version) +
                                ", expected " + std::to_string(kWorldFileVersion) +
                                "; write it with the same version of halfphysics as this library");
  if (number<uint64_t>(header + 16) != size - kHeader || size > kMostBytes || size % 8 != 0)
    broken("its size is not the one that it names");
}

}  // namespace

WorldFile::WorldFile(const void* bytes, size_t size) {
  static_assert(sizeof(int) == 4 && sizeof(double) == 8);
  const auto* file = static_cast<const unsigned char*>(bytes);
  check_header(file, size);
  words_.resize((size - kHeader) / 8);
  const size_t body = size - kHeader;
  if (body > 0) std::memcpy(words_.data(), file + kHeader, body);
  const auto* begin = reinterpret_cast<const unsigned char*>(words_.data());
  checksum_ = crc32(begin, body);
  if (checksum_ != number<uint32_t>(file + 12)) broken("its checksum is wrong");
  Cursor in{begin, begin + body};
  const uint32_t count = number<uint32_t>(file + 24);
  if (count > body / kCallHeader) broken("it ends too early");
  calls_.reserve(count);
  for (uint32_t i = 0; i < count; i++) {
    RecordedCall call;
    const uint32_t arguments = in.u32();
    in.u32();
    call.name = in.name(kName);
    if (arguments > in.left() / kArgumentHeader) broken("it ends too early");
    call.arguments.reserve(arguments);
    for (uint32_t k = 0; k < arguments; k++) call.arguments.push_back(argument(in));
    calls_.push_back(std::move(call));
  }
  if (in.left() > 0) broken("there is more in it than its calls");
}

}  // namespace hp
