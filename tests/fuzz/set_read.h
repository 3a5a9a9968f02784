// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>

#include "host/sets/check_set.h"
#include "host/sets/contact_set.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {

/// Reads a set file in every way that the program does: whole, by parts, its sweep alone. The ways must agree.
inline void read_set(const std::filesystem::path& path) {
  host::ContactSet whole;
  const bool is_set = accepts([&] { whole = host::read_contact_set(path); });
  if (is_set) {
    host::each_dataset(whole, [&](const char*, const auto& values, int columns, const char*) {
      check(values.size() == whole.rows() * static_cast<std::size_t>(std::max(columns, 1)),
            "datasets are of one length");
    });
    if (whole.rows() > 0)
      check(whole.frames_with_answers().frames.cols() == whole.inputs, "frames are as wide as said");
  }
  accepts([&] { host::contact_set_sweep(path); });
  accepts([&] { host::check_contact_set(path, {}); });
  accepts([&] {
    const host::ContactSetReader reader(path);
    if (is_set)
      check(reader.rows() == whole.rows() && reader.columns().inputs == whole.inputs, "both readers see one size");
    if (reader.rows() == 0) return;
    const std::uint64_t some = std::min<std::uint64_t>(reader.rows(), 2);
    const host::ContactSet first = reader.read(0, some), last = reader.read(reader.rows() - 1, 1);
    check(first.rows() == some && last.rows() == 1, "a part has the rows that were asked for");
    if (is_set) check(std::ranges::equal(first.indenter_names, whole.indenter_names), "both readers see one attribute");
  });
}

}  // namespace tactel::fuzz
