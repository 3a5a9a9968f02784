#pragma once
#include <string>
#include <vector>

#include "host/log.h"
#include "host/scene_source.h"
#include "host/set_simulator.h"
#include "host/set_spool.h"

namespace tactel::host {

/// Contacts of a chunk: what is simulated, checked and kept as a whole.
inline constexpr std::uint64_t chunk_contacts = 8192;
std::uint64_t chunk_count(const SceneSource& source);

struct ProductionOptions {
  std::vector<std::string> devices{""};  ///< names or indices; several share the chunks
  SetOptions set;
  int rank = 0, ranks = 1;  ///< this process makes the chunks whose number leaves `rank` over `ranks`
  Progress progress;        ///< chunks of this process done of all that it has to do; false stops
};

struct ProductionReport {
  bool finished = false;  ///< false: progress said stop
  std::uint64_t contacts = 0, rows = 0, steps = 0;
  double seconds = 0;                ///< wall time
  double kernel_seconds = 0;         ///< in kernels, summed over devices
  double write_seconds = 0;          ///< appending to the spool
  std::vector<std::string> devices;  ///< their full names
};

/// Simulates the chunks that the spool lacks, into it. On each device three threads work side by side: one draws the
/// next chunk's contacts and lays them out, one runs kernels, one gathers rows and writes them; at most two chunks wait
/// between them. Throws what any of them threw, after all have stopped.
ProductionReport produce_set(const SceneSource& source, SetSpool& spool, const ProductionOptions& options);

}  // namespace tactel::host
