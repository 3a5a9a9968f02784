// SPDX-License-Identifier: Apache-2.0

// Set files (HDF5) of any structure. The input says what becomes of a whole set: which attribute or dataset goes, or is
// replaced by one of another type, rank and extent. HDF5's own library is not what is looked at here; see
// fuzz_set_file.
#include <array>
#include <vector>

#include "host/sets/hdf5_handle.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/set_read.h"
#include "tests/fuzz/small_set.h"

namespace tactel::fuzz {
namespace {

using host::Handle;

const std::string& whole_set() {
  static const std::string bytes = [] {
    const auto path = folder() / "whole.h5";
    host::write_contact_set(path, small_set());
    return text_of(path);
  }();
  return bytes;
}

/// Names of the root's attributes, or of what is linked there.
std::vector<std::string> names(hid_t file, bool attributes) {
  std::vector<std::string> found;
  if (attributes) {
    const auto add = [](hid_t, const char* name, const H5A_info_t*, void* into) -> herr_t {
      static_cast<std::vector<std::string>*>(into)->emplace_back(name);
      return 0;
    };
    H5Aiterate2(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &found);
  } else {
    const auto add = [](hid_t, const char* name, const H5L_info_t*, void* into) -> herr_t {
      static_cast<std::vector<std::string>*>(into)->emplace_back(name);
      return 0;
    };
    H5Literate(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &found);
  }
  return found;
}

hid_t text_type(std::size_t size) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, size);
  return type;
}

hid_t compound_type() {
  const hid_t type = H5Tcreate(H5T_COMPOUND, 8);
  H5Tinsert(type, "a", 0, H5T_NATIVE_INT32);
  H5Tinsert(type, "b", 4, H5T_NATIVE_FLOAT);
  return type;
}

hid_t array_type() {
  const hsize_t three = 3;
  return H5Tarray_create2(H5T_NATIVE_FLOAT, 1, &three);
}

Handle chosen_type(Choices& choices) {
  constexpr std::array<hid_t (*)(), 11> makers{[] { return H5Tcopy(H5T_NATIVE_FLOAT); },
                                               [] { return H5Tcopy(H5T_NATIVE_DOUBLE); },
                                               [] { return H5Tcopy(H5T_STD_I64BE); },
                                               [] { return H5Tcopy(H5T_NATIVE_UINT8); },
                                               [] { return text_type(1); },
                                               [] { return text_type(20); },
                                               [] { return text_type(4000); },
                                               [] { return text_type(H5T_VARIABLE); },
                                               compound_type,
                                               array_type,
                                               [] { return H5Tcopy(H5T_STD_REF_OBJ); }};
  return {makers[choices.below(makers.size())](), H5Tclose};
}

struct Extent {
  int rank;
  std::array<hsize_t, 4> size;
};

Extent chosen_extent(Choices& choices, bool sparse) {
  constexpr hsize_t rows = small_rows, inputs = small_inputs;
  constexpr std::array<hsize_t, 8> small{0, 1, 2, rows, rows + 1, inputs, inputs + 1, 1000};
  constexpr std::array<hsize_t, 4> large{hsize_t{1} << 20, hsize_t{1} << 31, hsize_t{1} << 40, hsize_t{1} << 62};
  constexpr hsize_t most = 4000;  // numbers that are there: HDF5 keeps an attribute in memory
  Extent extent{static_cast<int>(choices.below(5)), {}};
  hsize_t count = 1;
  for (int i = 0; i < extent.rank; ++i) {
    const std::size_t place = choices.below(sparse ? small.size() + large.size() : small.size());
    hsize_t& size = extent.size[static_cast<std::size_t>(i)];
    size = place < small.size() ? small[place] : large[place - small.size()];
    if (!sparse && count * size > most) size = 1;
    count *= size;
  }
  return extent;
}

Handle space_of(const Extent& extent) {
  if (extent.rank == 0) return {H5Screate(H5S_SCALAR), H5Sclose};
  return {H5Screate_simple(extent.rank, extent.size.data(), nullptr), H5Sclose};
}

/// Writes `bytes` bytes of the input, and zeros, so that texts of variable length stay null.
std::vector<char> content(Choices& choices, hid_t type, hid_t space) {
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  std::vector<char> bytes(static_cast<std::size_t>(count) * H5Tget_size(type));
  const bool plain = !H5Tis_variable_str(type) && H5Tget_class(type) != H5T_REFERENCE;
  for (std::size_t i = 0; plain && i < bytes.size() && !choices.empty(); ++i)
    bytes[i] = static_cast<char>(choices.byte());
  return bytes;
}

void put_attribute(Choices& choices, hid_t file, const std::string& name) {
  const Handle type = chosen_type(choices), space = space_of(chosen_extent(choices, false));
  const Handle attribute(H5Acreate2(file, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (attribute < 0) return;
  const bool empty = H5Sget_simple_extent_npoints(space) == 0;
  if (H5Tis_variable_str(type) > 0) {
    static const char* texts[1000];
    for (const char*& text : texts) text = "tactel contact set 1";
    if (H5Sget_simple_extent_npoints(space) <= 1000 && choices.below(4) > 0) H5Awrite(attribute, type, texts);
  } else if (!empty) {
    H5Awrite(attribute, type, content(choices, type, space).data());
  }
}

void put_dataset(Choices& choices, hid_t file, const std::string& name) {
  const bool sparse = choices.below(2) == 1;
  const Extent extent = chosen_extent(choices, sparse);
  const Handle type = chosen_type(choices), space = space_of(extent);
  const Handle how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  if (sparse && extent.rank > 0) {
    const std::array<hsize_t, 4> chunk{1, 1, 1, 1};
    H5Pset_chunk(how, extent.rank, chunk.data());
  }
  const Handle data(H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, how, H5P_DEFAULT), H5Dclose);
  const bool plain = H5Tis_variable_str(type) <= 0 && H5Tget_class(type) != H5T_REFERENCE;
  if (data >= 0 && !sparse && plain && H5Sget_simple_extent_npoints(space) <= 1000)
    H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, content(choices, type, space).data());
}

/// Carries out what the input says, at most eight changes.
void change(hid_t file, Choices choices) {
  for (int i = 0; i < 8 && !choices.empty(); ++i) {
    const bool attribute = choices.below(2) == 0;
    const std::vector<std::string> there = names(file, attribute);
    if (there.empty()) continue;
    const std::string name = there[choices.below(there.size())];
    const bool replace = choices.below(4) > 0;
    if (attribute) {
      H5Adelete(file, name.c_str());
      if (replace) put_attribute(choices, file, name);
    } else {
      H5Ldelete(file, name.c_str(), H5P_DEFAULT);
      if (replace && choices.below(8) == 0)
        H5Gclose(H5Gcreate2(file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
      else if (replace)
        put_dataset(choices, file, name);
    }
  }
}

const Target set("set", [](Bytes input) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const std::string& whole = whole_set();
  const auto path = write_file("set.h5", as_bytes(whole));
  {
    const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
    check(file >= 0, "a whole set opens");
    change(file, Choices(input));
  }
  read_set(path);
});

}  // namespace
}  // namespace tactel::fuzz
