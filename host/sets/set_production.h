// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "fem/pad/pad_markers.h"
#include "host/scenes/scene_source.h"
#include "host/sets/set_simulator.h"
#include "host/sets/set_spool.h"
#include "host/support/log.h"

namespace tactel::host {

/// Contacts of a chunk, the unit of simulation, checksum and storage; of grips, which have hundreds of rows, and with
/// many markers, fewer.
inline constexpr std::uint64_t chunk_contacts = 8192, chunk_grips = 512, few_markers = 64;
inline std::uint64_t contacts_of_chunk(const AnySource& source) {
  const auto* pads = std::get_if<PadSource>(&source);
  if (pads == nullptr) return chunk_contacts;
  const std::uint64_t markers = std::max<std::uint64_t>(fem::marker_count(pads->markers()), few_markers);
  return (pads->holds() ? chunk_grips : chunk_contacts) * few_markers / markers;
}
std::uint64_t chunk_count(const AnySource& source);

/// Returns the bytes of a set, but for its headers. Rows are counted on some of its contacts; a drag until sliding
/// counts as one row, which is the least.
double expected_bytes(const AnySource& source, const SetColumns& columns);

struct ProductionOptions {
  std::vector<std::string> devices{""};  ///< names or indices; several share the chunks
  SetOptions set;
  Progress progress;  ///< contacts of this process; false stops
};

struct ProductionReport {
  bool finished = false;  ///< false: stopped by progress
  std::uint64_t contacts = 0, rows = 0, steps = 0;
  double seconds = 0;                ///< wall time
  double kernel_seconds = 0;         ///< in kernels, summed over devices and launches side by side
  double write_seconds = 0;          ///< to write chunks, without waiting
  StageSeconds stages;               ///< summed over threads
  std::vector<std::string> devices;  ///< their full names
};

/// Simulates chunks of a set and appends them to the spool. Each device has one thread more than it computes with,
/// eight at most; a GPU eight. A thread draws the contacts of a chunk, lays them out, solves them, gathers their rows
/// and appends them, then takes the next chunk. The calling thread shows progress. Rethrows the exception of any thread
/// after all have stopped.
ProductionReport produce_set(const AnySource& source, SetSpool& spool, const std::vector<std::uint64_t>& chunks,
                             const ProductionOptions& options);

}  // namespace tactel::host
