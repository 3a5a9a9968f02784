// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_seal.h"

#include <fmt/format.h>

#include <cstdint>
#include <map>

#include "host/sets/hdf5_handle.h"
#include "host/support/checksum.h"

namespace tactel::host {
namespace {

constexpr hsize_t most_value_bytes = hsize_t{1} << 28;

/// With its length, so that no two lists of texts are the same bytes.
void add(RunningChecksum& sum, std::string_view text) {
  const std::uint64_t size = text.size();
  sum.add({reinterpret_cast<const char*>(&size), sizeof size});
  sum.add(text);
}

/// Kind and bytes of an attribute, as the file has them. What tactel does not write has no bytes: texts of variable
/// length, and what is longer than any attribute of a set.
std::string attribute_bytes(hid_t object, const char* name) {
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  if (!attribute.open()) return "missing";
  const Handle type(H5Aget_type(attribute), H5Tclose);
  const hsize_t size = H5Aget_storage_size(attribute);
  const bool in_place = H5Tdetect_class(type, H5T_VLEN) == 0 && H5Tis_variable_str(type) == 0;
  std::string bytes(in_place && size <= most_value_bytes ? size : 0, '\0');
  if (!bytes.empty() && H5Aread(attribute, type, bytes.data()) < 0) return "unreadable";
  return fmt::format("{} of {}: {}", static_cast<int>(H5Tget_class(type)), H5Tget_size(type), bytes);
}

herr_t add_attribute(hid_t object, const char* name, const H5A_info_t*, void* sum) {
  if (std::string_view(name) == seal_name) return 0;
  add(*static_cast<RunningChecksum*>(sum), name);
  add(*static_cast<RunningChecksum*>(sum), attribute_bytes(object, name));
  return 0;
}

void add_attributes(RunningChecksum& sum, hid_t object) {
  H5Aiterate(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, add_attribute, &sum);
}

/// Adds the seal of a link to those of all, by name.
herr_t find_seal(hid_t file, const char* name, const H5L_info_t* link, void* seals) {
  std::string seal;
  if (link->type == H5L_TYPE_HARD) {
    const Handle object(H5Oopen(file, name, H5P_DEFAULT), H5Oclose);
    seal = attribute_bytes(object, seal_name);
  }
  static_cast<std::map<std::string, std::string>*>(seals)->emplace(name, seal);
  return 0;
}

}  // namespace

std::string dataset_seal(hid_t dataset, std::string_view name, std::string_view numbers) {
  RunningChecksum sum;
  add(sum, name);
  add_attributes(sum, dataset);
  add(sum, numbers);
  return sum.text();
}

std::string file_seal(hid_t file) {
  RunningChecksum sum;
  add_attributes(sum, file);
  // In the file's own order: for another one HDF5 1.10 makes a table, and of a damaged file frees what it never wrote.
  std::map<std::string, std::string> seals;
  H5Literate(file, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, find_seal, &seals);
  for (const auto& [name, seal] : seals) add(sum, name), add(sum, seal);
  return sum.text();
}

}  // namespace tactel::host
