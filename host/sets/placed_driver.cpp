// SPDX-License-Identifier: Apache-2.0
#include "host/sets/placed_driver.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace tactel::host {
namespace {

/// A file of HDF5's, as its drivers keep it: what the library needs comes first.
struct OpenFile {
  H5FD_t library{};
  PlacedFile* placed = nullptr;
  haddr_t allocated = 0, written = 0;  ///< ends of the space given away, and of what was written
};

OpenFile& opened(H5FD_t* file) { return *reinterpret_cast<OpenFile*>(file); }
const OpenFile& opened(const H5FD_t* file) { return *reinterpret_cast<const OpenFile*>(file); }

H5FD_t* open_placed(const char*, unsigned, hid_t access, haddr_t) {
  const auto* placed = static_cast<PlacedFile* const*>(H5Pget_driver_info(access));
  return placed ? &(new OpenFile{.placed = *placed})->library : nullptr;
}

herr_t close_placed(H5FD_t* file) {
  opened(file).placed->end = opened(file).allocated;
  delete &opened(file);
  return 0;
}

herr_t no_features(const H5FD_t*, unsigned long* flags) {
  *flags = 0;
  return 0;
}

/// Chunks where they are; the superblock at the beginning; all else behind the chunks, in the order of the calls.
haddr_t allocate_placed(H5FD_t* file, H5FD_mem_t type, hid_t, hsize_t size) {
  OpenFile& open = opened(file);
  const PlacedFile& placed = *open.placed;
  haddr_t at = 0;
  if (type == H5FD_MEM_DRAW && placed.chunk > 0)
    at = placed.chunk;
  else if (type != H5FD_MEM_SUPER)
    at = (std::max<haddr_t>(placed.end, open.allocated) + 7) / 8 * 8;
  open.allocated = std::max<haddr_t>(open.allocated, at + size);
  return at;
}

haddr_t allocated_end(const H5FD_t* file, H5FD_mem_t) { return opened(file).allocated; }

/// Called where the last part grows or goes.
herr_t set_allocated_end(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  opened(file).allocated = end;
  return 0;
}

haddr_t written_end(const H5FD_t* file, H5FD_mem_t) { return opened(file).written; }

herr_t read_placed(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, size_t size, void* to) {
  auto* bytes = static_cast<char*>(to);
  while (size > 0) {
    const ssize_t count = ::pread(opened(file).placed->file, bytes, size, static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return -1;
    if (count == 0) {  // behind the end
      std::memset(bytes, 0, size);
      break;
    }
    bytes += count, at += static_cast<haddr_t>(count), size -= static_cast<size_t>(count);
  }
  return 0;
}

herr_t write_placed(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t at, size_t size, const void* from) {
  OpenFile& open = opened(file);
  open.written = std::max<haddr_t>(open.written, at + size);
  const auto* bytes = static_cast<const char*>(from);
  if (type == H5FD_MEM_DRAW && open.placed->chunk > 0) return 0;
  while (size > 0) {
    const ssize_t count = ::pwrite(open.placed->file, bytes, size, static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return -1;
    bytes += count, at += static_cast<haddr_t>(count), size -= static_cast<size_t>(count);
  }
  return 0;
}

H5FD_class_t driver_class() {
  H5FD_class_t driver{};
  driver.name = "tactel_placed";
  driver.maxaddr = (haddr_t{1} << 62) - 1;
  driver.fc_degree = H5F_CLOSE_STRONG;
  driver.fapl_size = sizeof(void*);
  driver.open = open_placed;
  driver.close = close_placed;
  driver.query = no_features;
  driver.alloc = allocate_placed;
  driver.get_eoa = allocated_end;
  driver.set_eoa = set_allocated_end;
  driver.get_eof = written_end;
  driver.read = read_placed;
  driver.write = write_placed;
  driver.lock = [](H5FD_t*, hbool_t) -> herr_t { return 0; };  // HDF5 may ask for it; PlacedSet has a lock
  driver.unlock = [](H5FD_t*) -> herr_t { return 0; };
  const H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
  std::ranges::copy(map, driver.fl_map);
  return driver;
}

}  // namespace

Handle placed_access(PlacedFile& placed) {
  static const H5FD_class_t driver = driver_class();
  static const hid_t registered = H5FDregister(&driver);
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  PlacedFile* const info = &placed;
  if (H5Pset_driver(access, registered, &info) < 0) access.close();
  return access;
}

}  // namespace tactel::host
