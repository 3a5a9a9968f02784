// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/shape_reader.h"

#include "host/scenes/number_reader.h"
#include "host/scenes/profile_csv.h"
#include "host/scenes/scene_tables.h"

namespace tactel::host {
namespace {

template <class S>
void read_shape(TomlTable& in, const TomlFile&, S& shape, bool complete) {
  read_numbers(in, shape, complete);
}
void read_shape(TomlTable& in, const TomlFile&, fem::Taylor& taylor, bool) { read_numbers(in, taylor, true); }
void read_shape(TomlTable& in, const TomlFile& file, fem::Profile& profile, bool) {
  in.read("smooth", profile.smooth, "a number of mm, at least 0");
  std::string name;
  const bool from_file = in.read("file", name, "the name of a CSV file with columns x,y in mm");
  const bool has_x = in.read("x", profile.x, "an array of mm, increasing");
  const bool has_y = in.read("y", profile.y, "an array of mm, as many as x");
  if (from_file && (has_x || has_y)) in.refuse("file", "left out, because the profile's x and y are given too");
  if (!from_file && !has_x)
    in.refuse_missing("x", "given, an array of mm, increasing (or file, a CSV file with columns x,y)");
  if (!from_file && !has_y) in.refuse_missing("y", "given, an array of mm, as many as x");
  if (!from_file) return;
  const std::filesystem::path path = file.path().parent_path() / name;
  read_profile_csv(path, profile);
  profile.file = path.string();
}

}  // namespace

void read_indenter(const TomlFile& file, fem::Indenter& indenter, bool preset) {
  TomlTable in(file, "indenter");
  refuse_other_kind<fem::Shape, fem::PadShape>(in, {"yaw", "young", "poisson"}, of_a_pad);
  const auto& chosen = choose_shape(in, {"shape", "position"}, preset ? &indenter.shape : nullptr);
  const bool known = preset && chosen.name == fem::shape_name(indenter.shape);
  if (!known) indenter.shape = chosen.made;
  std::visit([&](auto& shape) { read_shape(in, file, shape, !known); }, indenter.shape);
  read_numbers(in, indenter, false);
  in.finish();
}

}  // namespace tactel::host
