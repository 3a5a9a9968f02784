// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "host/sets/hdf5_handle.h"

namespace tactel::host {

/// Where HDF5 puts the parts of a file whose chunks are already in place: it writes headers and indices alone.
struct PlacedFile {
  int file = -1;            ///< descriptor, open for reading and writing
  std::uint64_t chunk = 0;  ///< offset of the chunk that is written next; 0: none is
  std::uint64_t end = 0;    ///< of the chunks, after which come all headers but the superblock; of the file once closed
};

/// Returns a list of properties with which H5Fcreate makes the headers of `placed`, which must outlive the file. What
/// is written to chunks is dropped, since it is there. Long attributes count as data, too, and are not dropped.
Handle placed_access(PlacedFile& placed);

}  // namespace tactel::host
