// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <memory>

#include "host/device/executor.h"
#include "host/networks/frame_stream.h"
#include "host/sets/set_simulator.h"
#include "nn/presentation_order.h"

namespace tactel::host {

/// What a network learns of the rows: answered_rows, shown_rows.
struct ShownRows {
  nn::InputHistory history{};
  bool magnitude = false;
  nn::Target target = nn::Target::slip_index;
  bool markers = false;
};

/// Returns an endless stream of contacts, simulated on demand and never stored. Block k holds `contacts` new
/// ones, modelled by the rung of this name or, where it is empty, as the file says. The stream is the only user of
/// `executor` while blocks are taken.
std::unique_ptr<FrameStream> simulated_stream(Executor& executor, const std::filesystem::path& sweep_file,
                                              std::uint64_t contacts, const std::string& rung,
                                              const SetOptions& options, const ShownRows& shown = {});

/// Returns a stream of the rows of a set file, `rows` at a time. Every pass takes the blocks in the order of the
/// file, or in another permutation drawn from `seed`. Rows over tolerance or without a finite slippage index are
/// excluded. With history, a block takes whole contacts: those whose first row is among its rows. Throws ConfigError
/// for a set without rows.
std::unique_ptr<FrameStream> file_stream(const std::filesystem::path& set_file, std::uint64_t rows, std::uint64_t seed,
                                         nn::PresentationOrder order = nn::PresentationOrder::permuted,
                                         const ShownRows& shown = {});

}  // namespace tactel::host
