// SPDX-License-Identifier: Apache-2.0

// Spools of unfinished sets: the input is the headers of chunks, beside the
// rows of two and a plan that fits. What is taken of it is put together. The
// input is read as it is, then with the checksums of its headers made right.
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
  for (std::size_t at = 0; at + sizeof(ChunkHeader) <= bytes.size(); at += sizeof(ChunkHeader)) {
    ChunkHeader header;
    std::memcpy(&header, bytes.data() + at, sizeof header);
    header.header_sum = header.sum();
    std::memcpy(bytes.data() + at, &header, sizeof header);
  }
  return bytes;
}

void read(const std::string& bytes) {
  const fs::path output = folder() / "set.h5", parts = host::SetSpool::folder(output);
  static const std::string rows = (write_small_spool(output), file_bytes(parts / "set"));
  fs::remove(output);
  fs::create_directories(parts);
  write_file((parts.filename() / "plan").string(), as_bytes(spool_plan));
  write_file((parts.filename() / "set").string(), as_bytes(rows));
  write_file((parts.filename() / "0000.placed").string(), as_bytes(bytes));
  const bool taken = accepts([&] {
    std::uint64_t chunks = 0;
    {
      const host::SetSpool spool(output, spool_plan, small_inputs, small_chunks, host::SetSpool::Open::resume);
      chunks = spool.chunks();
    }
    check(chunks <= small_chunks, "no more chunks than rows");
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

const Target target("spool", [](Bytes input) { read_twice(input, read, with_right_checksums); });

}  // namespace
}  // namespace tactel::fuzz
