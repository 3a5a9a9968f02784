// SPDX-License-Identifier: Apache-2.0

// Spools of unfinished sets: the input is a file of chunks beside a plan that
// fits. What is taken of it is put together. The input is read as it is, then
// with the checksums of its chunks made right.
#include <cstring>

#include "host/sets/set_spool.h"
#include "host/support/checksum.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/small_set.h"

namespace tactel::fuzz {
namespace {

namespace fs = std::filesystem;
using host::ChunkHeader;

std::string with_right_checksums(std::string bytes) {
  for (std::size_t at = 0; at + sizeof(ChunkHeader) <= bytes.size();) {
    ChunkHeader header;
    std::memcpy(&header, bytes.data() + at, sizeof header);
    const std::size_t rows_at = at + sizeof header;
    if (header.bytes > bytes.size() - rows_at) break;
    header.payload_sum = host::checksum(std::string_view(bytes).substr(rows_at, header.bytes));
    header.header_sum = host::checksum({reinterpret_cast<const char*>(&header), offsetof(ChunkHeader, header_sum)});
    std::memcpy(bytes.data() + at, &header, sizeof header);
    at = rows_at + header.bytes;
  }
  return bytes;
}

void read(const std::string& bytes) {
  const fs::path output = folder() / "set.h5", parts = host::SetSpool::folder(output);
  fs::create_directories(parts);
  fs::remove(output);
  write_file((parts.filename() / "plan").string(), as_bytes(spool_plan));
  write_file((parts.filename() / "0000.spool").string(), as_bytes(bytes));
  const bool taken = accepts([&] {
    host::SetSpool spool(output, spool_plan, small_inputs, 1, host::SetSpool::Open::resume);
    const std::uint64_t chunks = spool.chunks().size(), rows = spool.rows();
    host::ContactSet set;
    set.inputs = small_inputs;
    spool.assemble(chunks, set);
    check(host::read_contact_set(output).rows() == rows, "the set has the rows of the chunks");
  });
  if (!taken) host::SetSpool::discard(output);
  check(!fs::exists(parts), "nothing is left of a spool that was put together or dropped");
}

}  // namespace
}  // namespace tactel::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tactel::fuzz::read_twice(data, size, tactel::fuzz::read, tactel::fuzz::with_right_checksums);
  return 0;
}
