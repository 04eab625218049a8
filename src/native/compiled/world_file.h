// World files: the calls that build a world, with their arguments, as Python made them (docs/c-api.md, "World files").
//
// Little-endian; everything begins at a multiple of eight bytes. A header of 32 bytes:
//
//     0   8  magic 89 48 50 57 0D 0A 1A 0A ("\x89HPW\r\n\x1a\n")
//     8   4  version of the layout, 1
//    12   4  CRC-32 of all that follows the header
//    16   8  its size in bytes
//    24   4  number of calls
//    28   4  0
//
// then the calls, one after the other: number of arguments (4 bytes), 0 (4), name (24, padded by zeros); and after it each
// argument: name (24, padded by zeros), type (4: 1 int32, 2 float64, 3 text in UTF-8), number of dimensions (4, at
// most 3), shape (3 x 8), values, padded to a multiple of eight.
//
// Nothing in a file is believed: sizes are compared with what is there before anything is looked at, and no memory is
// taken but a copy of the file and one record per argument.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hp {

constexpr uint32_t kWorldFileVersion = 1;

struct Argument {
  enum class Type : uint32_t { Int = 1, Double = 2, Text = 3 };
  std::string_view name;
  Type type;
  uint32_t dims;
  size_t shape[3];   // 1 where there is no such dimension
  const void* data;  // aligned to eight bytes

  size_t count() const { return shape[0] * shape[1] * shape[2]; }
};

struct RecordedCall {
  std::string_view name;
  std::vector<Argument> arguments;
};

class WorldFile {
 public:
  // Throws std::invalid_argument with what was found, what was expected and the way out.
  WorldFile(const void* bytes, size_t size);
  WorldFile(const WorldFile&) = delete;
  WorldFile& operator=(const WorldFile&) = delete;

  const std::vector<RecordedCall>& calls() const { return calls_; }
  // Tells files apart: their checksum.
  uint32_t checksum() const { return checksum_; }

 private:
  std::vector<uint64_t> words_;  // all that follows the header
  std::vector<RecordedCall> calls_;
  uint32_t checksum_ = 0;
};

}  // namespace hp
