// SPDX-License-Identifier: Apache-2.0
#include "host/api/conversion.h"

namespace tactel {
namespace api {
Set from_host(host::ContactSet&& from) {
  Set set;
  static_cast<SetArrays&>(set) = std::move(static_cast<SetArrays&>(from));
  set.inputs = static_cast<std::size_t>(from.inputs), set.axes = static_cast<std::size_t>(from.axes);
  set.tactel_x = std::move(from.tactel_x), set.tactel_y = std::move(from.tactel_y);
  set.parameter_names = std::move(from.parameter_names), set.parameter_units = std::move(from.parameter_units);
  set.fell_back = from.fell_back, set.unsolved = from.unsolved, set.without_rows = from.without_rows;
  return set;
}

host::ContactSet to_host(const Set& from) {
  host::ContactSet set;
  static_cast<SetArrays&>(set) = from;
  set.inputs = static_cast<int>(from.inputs), set.axes = static_cast<int>(from.axes), set.pad = from.axes != 2;
  set.sensors = !(from.poisson.empty() && from.thickness.empty() && from.young.empty() && from.length.empty());
  if (from.rows() > 0) {
    set.marker_numbers = static_cast<int>(from.markers.size() / from.rows() / 3 * 3);
    set.pixel_numbers = static_cast<int>(from.pixels.size() / from.rows() / 2 * 2);
  }
  host::each(host::set_columns(set), [&](const auto& column) {
    const std::size_t numbers = from.rows() * static_cast<std::size_t>(column.width(set));
    if (column.value.size() != numbers && !column.value.empty())
      throw InputError("set", std::to_string(column.value.size()) + " numbers of an array",
                       "give " + std::to_string(numbers) + ", for " + std::to_string(from.rows()) + " rows");
  });
  each_dataset(set, [&](const char* name, auto& values, int width, const char*) {
    if (!values.empty() || from.rows() == 0) return;
    set.left_out.insert(name);  // unknown, and not 0: no dataset
    values.resize(from.rows() * static_cast<std::size_t>(width > 0 ? width : 1));
  });
  for (const auto* places : {&from.tactel_x, &from.tactel_y})
    if (!places->empty() && !from.frames.empty() && from.axes * places->size() != from.inputs)
      throw InputError("set", std::to_string(places->size()) + " places of tactels",
                       "give " + std::to_string(from.inputs / from.axes) + ", or none");
  if (from.parameters.size() != from.contacts * from.parameter_names.size() ||
      from.parameter_units.size() != from.parameter_names.size())
    throw InputError("set", std::to_string(from.parameters.size()) + " parameters",
                     "give one for each contact and name, and a unit for each name");
  set.tactel_x = from.tactel_x, set.tactel_y = from.tactel_y;
  set.parameter_names = from.parameter_names, set.parameter_units = from.parameter_units;
  set.fell_back = from.fell_back, set.unsolved = from.unsolved, set.without_rows = from.without_rows;
  return set;
}

}  // namespace api

Set read_set(const std::string& path) {
  return api::with_public_errors([&] { return api::from_host(host::read_contact_set(path)); });
}

void write_set(const Set& set, const std::string& path) {
  const host::ContactSet rows = api::to_host(set);
  api::with_public_errors([&] { host::write_contact_set(path, rows); });
}

}  // namespace tactel
