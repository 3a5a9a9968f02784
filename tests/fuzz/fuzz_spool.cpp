// SPDX-License-Identifier: Apache-2.0

// Spools of unfinished sets: the input is the file of a process, with chunks
// behind their headers, beside a plan that fits. What is taken of it is put
// together. The input is read as it is, then with its checksums made right.
#include <cstring>

#include "host/sets/set_spool.h"
#include "host/support/checksum.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/small_spool.h"

namespace tactel::fuzz {
namespace {

namespace fs = std::filesystem;
using host::ChunkHeader;

std::string with_right_checksums(std::string bytes) {
  for (std::size_t at = 0; at + sizeof(ChunkHeader) <= bytes.size();) {
    ChunkHeader header;
    std::memcpy(&header, bytes.data() + at, sizeof header);
    const std::size_t begin = at + sizeof header, rows = std::min<std::uint64_t>(header.bytes, bytes.size() - begin);
    header.payload_sum = host::checksum(std::string_view(bytes).substr(begin, rows));
    header.header_sum = header.sum();
    std::memcpy(bytes.data() + at, &header, sizeof header);
    at = begin + rows;
  }
  return bytes;
}

void read(const std::string& bytes) {
  const fs::path output = folder() / "set.h5", parts = host::SetSpool::folder(output);
  fs::create_directories(parts);
  write_file((parts.filename() / "plan").string(), as_bytes(spool_plan));
  write_file((parts.filename() / "0000.chunks").string(), as_bytes(bytes));
  const bool taken = accepts([&] {
    std::uint64_t chunks = 0;
    {
      const host::SetSpool spool(output, spool_plan, small_inputs, small_chunks, host::SetSpool::Open::resume);
      chunks = small_chunks - host::missing_chunks(spool.found()).size();
    }
    host::SetSpool spool(output, spool_plan, small_inputs, chunks, host::SetSpool::Open::resume);
    const std::uint64_t all = spool.rows();
    host::ContactSet set;
    set.inputs = small_inputs;
    spool.assemble(set);
    check(host::read_contact_set(output).rows() == all, "the set has the rows of the chunks");
  });
  if (!taken) host::SetSpool::discard(output);
  check(!fs::exists(parts), "nothing is left of a spool that was put together or dropped");
}

const Target spool("spool", [](Bytes input) { read_twice(input, read, with_right_checksums); });

}  // namespace
}  // namespace tactel::fuzz
