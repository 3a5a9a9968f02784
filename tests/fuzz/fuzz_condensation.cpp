// SPDX-License-Identifier: Apache-2.0

// The file cache of condensations. The input says how a whole file is damaged: where to begin, what to do, and the
// bytes to write there. The answer must be that of a fresh condensation.

#include "fem/mesh/condensation.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

fem::Sensor small_sensor() {
  fem::Sensor sensor;
  sensor.columns = 3;
  sensor.rows = 2;
  sensor.tactels = 2;
  return sensor;
}

struct CacheFile {
  CacheFile() : fresh(fem::condense_cached(small_sensor(), folder())) {
    for (const auto& entry : std::filesystem::directory_iterator(folder())) path = entry.path();
    content = text_of(path);
    check(!content.empty(), "a condensation is kept");
  }
  fem::Condensation fresh;
  std::filesystem::path path;
  std::string content;
};

enum Damage { overwrite, insert, cut_off, replace_all, damages };

std::string damaged(std::string content, Bytes input) {
  Choices choices(input);
  const auto damage = static_cast<Damage>(choices.below(damages));
  const std::size_t at = choices.word() % (content.size() + 1);
  std::string bytes;
  while (!choices.empty()) bytes += static_cast<char>(choices.byte());
  if (damage == overwrite) return content.replace(at, std::min(bytes.size(), content.size() - at), bytes);
  if (damage == insert) return content.insert(at, bytes);
  return damage == cut_off ? content.substr(0, at) : bytes;
}

const Target condensation("condensation", [](Bytes input) {
  static const CacheFile file;
  const std::string bytes = damaged(file.content, input);
  write_file(file.path.filename(), as_bytes(bytes));
  const fem::Condensation found = fem::condense_cached(small_sensor(), folder());
  // A file with other values and the checksum of those is no damage: the fuzzer finds such files by watching the
  // comparison.
  if (bytes.size() == file.content.size() && bytes != file.content && text_of(file.path) == bytes) return;
  check(found.compliance == file.fresh.compliance && found.base_force == file.fresh.base_force &&
            found.tactel_stress == file.fresh.tactel_stress && found.surface_x == file.fresh.surface_x &&
            found.base_x == file.fresh.base_x && found.tactel_x == file.fresh.tactel_x,
        "a damaged file changes nothing");
  check(text_of(file.path) == file.content, "a damaged file is written anew");
});

}  // namespace
}  // namespace tactel::fuzz
